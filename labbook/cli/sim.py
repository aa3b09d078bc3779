"""`labbook sim`: the simulator; it needs no book."""

from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer

from labbook.cli.common import JsonOption
from labbook.cli.sim_warm import warm
from labbook.terminal import before_work, columns, counted, emit, progress

app = typer.Typer(no_args_is_help=True)


SceneOption = Annotated[
    str, typer.Option("--scene", metavar="NAME", help="bed, sim1, sim2, emulator, force_plate, or a .toml file.")
]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=VALUE",
        help="A parameter in SI units, or gain, flight, jumps, ...: see `labbook sim parts`; repeatable.",
    ),
]
EffectsOption = Annotated[
    str | None,
    typer.Option(
        "--effects", metavar="LIST", help="Effects on and off: +drag,-added_mass; auto: only those that matter."
    ),
]
WithinOption = Annotated[
    str | None,
    typer.Option("--within", metavar="SHARE", help="With --effects auto: the change that may pass, such as 1%."),
]
COMPILING = "compiling for up to 30 s, once"
AccuracyOption = Annotated[float, typer.Option("--accuracy", help="The relative error aimed at.")]


@app.command()
def run(
    scene: SceneOption,
    sets: SetOption = None,
    effects: EffectsOption = None,
    within: WithinOption = None,
    accuracy: AccuracyOption = 1e-6,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Draw the motion: a .png, .svg or .pdf file.")
    ] = None,
    animate: Annotated[
        Path | None, typer.Option("--animate", metavar="FILE", help="Make a moving picture: a .gif file.")
    ] = None,
    error_bars: Annotated[
        bool, typer.Option("--error-bars/--no-error-bars", help="Simulate a second time, a hundred times finer.")
    ] = True,
    as_json: JsonOption = False,
) -> None:
    """Simulate a scene and show its jump: times, heights, joules, how sure they are and what they rest on.

    Each number has an estimated error: the difference to a simulation a hundred times finer, whose values are shown.
    Of a scene with many jumps the last one is shown, and drawn. With --effects auto --within 1% the effects are left
    out that change cost, apex and depth by at most 1 % together (see labbook sim effects). --json gives every change of
    the contact mode by the kernel's names and, beside them, by those of the ground, as in the plot.

    Example: labbook sim run --scene sim2 --set b_ad=100 --effects +drag --accuracy 1e-8 --plot jump.png
    """
    from labbook.actions.simulate.pictures import ANIMATION_KINDS, draw_motion
    from labbook.actions.simulate.sweeping import auto_of, reduced_scene
    from labbook.presenting.simulation.effects_ablation import chosen_data, verdict
    from labbook.presenting.simulation.simulated import as_data, as_lines
    from reports.figures.kind import check_form
    from simulator.changes import changed_by_words
    from simulator.error_bars import simulate_with_errors
    from simulator.jump import simulate, with_other_contact
    from simulator.kernel.build import is_compiled
    from simulator.scene_file import load_scene

    check_form("--plot", plot)
    check_form("--animate", animate, ANIMATION_KINDS)
    auto = auto_of(effects, within, accuracy)
    simulated = simulate_with_errors if error_bars else simulate
    full = changed_by_words(load_scene(scene), sets or (), auto.words)
    first = "" if is_compiled(full.effects) else f"; where it takes long, {COMPILING}"
    with progress(f"simulating{first}", None, shown=not as_json) as step:
        ablation = auto.ablation(full, step)
        drawn = plot is not None or animate is not None
        result = simulated(reduced_scene(full, ablation), accuracy, trajectory=drawn)
        result = with_other_contact(result, simulated)
        if drawn:
            draw_motion(result, plot, animate)
    ablation_lines = [] if ablation is None else ["", *verdict(ablation)]
    files = {name: str(path) for name, path in (("plot", plot), ("animation", animate)) if path is not None}
    data = {**as_data(result), **chosen_data(ablation), **files}
    emit(data, [*as_lines(result), *ablation_lines, *files.values()], as_json)


@app.command()
def sweep(
    scene: SceneOption,
    over: Annotated[
        list[str],
        typer.Option(
            "--over",
            metavar="NAME=VALUES",
            help="What to sweep: LOW:HIGH:COUNT[:log] or VALUE,VALUE; for a sample LOW:HIGH[:log]; repeatable.",
        ),
    ],
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="The result: a .nc file or a .zarr folder.")],
    sets: SetOption = None,
    effects: EffectsOption = None,
    within: WithinOption = None,
    sobol: Annotated[
        int | None,
        typer.Option("--sobol", metavar="COUNT", help="Draw so many scenes (best a power of 2) from the ranges."),
    ] = None,
    seed: Annotated[int | None, typer.Option("--seed", help="Another seed draws another sample; 0 without it.")] = None,
    accuracy: AccuracyOption = 1e-6,
    error_bars: Annotated[
        bool, typer.Option("--error-bars", help="Simulate each scene a second time, a hundred times finer.")
    ] = False,
    error_bars_on: Annotated[
        str | None,
        typer.Option("--error-bars-on", metavar="SHARE", help="Error bars on so many of the scenes, such as 5%."),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option("--scheduler", metavar="URL", help="A Dask cluster's scheduler, tcp://HOST:PORT, to compute on."),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Simulate a scene over a grid, or a Sobol sample, of its parameters, on all cores, to an xarray Dataset in a file.

    A value outside its parameter's range is refused at once. Where values are in range but do not fit together, the
    sweep goes on without those scenes: it says how many they are and why, and in the file their outcome is refused and
    their numbers are NaN.

    With --error-bars the file has the finer values, as labbook sim run shows them, and an estimated error of each in a
    column NAME_error; ill_conditioned is then by these. With --error-bars-on 5% so do a twentieth of the scenes, spread
    evenly and the same ones each time; in the others the errors are NaN.

    Interrupted or killed, the same command goes on where it was; until the file is whole, FILE.part holds what is done.
    With --effects auto --within 1% the effects are left out that change the scene as it stands, before anything is
    swept, by at most 1 %; those that read what is swept stay. Farther out in the sweep the others may matter more: both
    sets are simulated at the corners of what is swept (at the ends of each range, where they are more than 16), and it
    is said how far off the worst is and where.

    Example: labbook sim sweep --scene sim2 --over b_ad=0:300:31 --over foot_radius=0.02,0.03,0.038 --out sweep.nc
    """
    from labbook.actions.simulate.sweeping import SweepRequest, error_bars_of, planned_sweep
    from labbook.presenting.simulation.effects_ablation import chosen_data, verdict
    from labbook.presenting.simulation.swept import corners_data, corners_lines, sweep_data, sweep_lines
    from simulator.kernel.build import is_compiled
    from simulator.sweep.chunks import why_scalar
    from simulator.sweep.compute import Threads, connect_cluster
    from simulator.sweep.run import run_sweep

    bars = error_bars_of(error_bars, error_bars_on)
    request = SweepRequest(scene, tuple(over), tuple(sets or ()), effects, accuracy, sobol, seed, within, bars)
    with progress("checking the sweep", None, shown=not as_json) as step:
        planned = planned_sweep(request, step)
    corners = corners_lines(planned.corners, planned.ablation)
    refused = [f"note: {planned.sweep.refused}"] if planned.sweep.refused else []
    if not as_json:
        before_work([*refused, *corners])
    computing = nullcontext(Threads()) if scheduler is None else connect_cluster(scheduler)
    sweep, lanes = planned.sweep, why_scalar(planned.sweep.scene, planned.sweep.design) is None
    here = scheduler is None and not is_compiled(sweep.scene.effects, lanes=lanes)
    first, wanted = f" after {COMPILING}" if here else "", sweep.jumps_wanted
    with counted(f"sweeping{first}", wanted, "jumps", shown=not as_json) as advance, computing as compute:
        done = run_sweep(sweep, out, compute, advance)
    chosen_for = "The effects were chosen for the scene as it stands, before anything is swept:"
    ablation_lines = [] if planned.ablation is None else ["", chosen_for, *verdict(planned.ablation), *corners]
    data = {**sweep_data(done), **chosen_data(planned.ablation), **corners_data(planned.corners, planned.ablation)}
    emit(data, [*sweep_lines(done), *ablation_lines], as_json)


@app.command()
def parts(
    name: Annotated[
        str | None, typer.Argument(help="An effect, a parameter or a word; without it, all of them.")
    ] = None,
    markdown: Annotated[
        bool, typer.Option("--markdown", help="Print the tables as Markdown, as docs/scenes.md has them.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """List what scenes are made of: effects, parameters with unit and range, and words that --set takes beside them.

    Of one effect: what it needs, what it excludes and why, what it reads, which shipped scenes have it. Of one
    parameter: its unit and range, which effects read it, and its value and source in the shipped scenes.

    Example: labbook sim parts k_extension
    """
    from labbook.presenting.simulation.scene_parts import (
        part_data,
        part_lines,
        parts_data,
        parts_markdown,
        parts_tables,
    )

    if name is not None:
        emit(part_data(name), part_lines(name), as_json)
        return
    lines = parts_markdown().splitlines()
    if not markdown:
        lines = []
        for table in parts_tables().values():
            head, *rows = table.texts
            lines += [table.caption, "", *columns(head, rows), ""]
        lines.append("labbook sim parts NAME says more of one of them.")
    emit(parts_data(), lines, as_json)


@app.command()
def accuracy(
    scene: SceneOption,
    sets: SetOption = None,
    effects: Annotated[
        str | None, typer.Option("--effects", metavar="LIST", help="Effects on and off: +drag,-added_mass.")
    ] = None,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Draw error against time: a .png, .svg or .pdf file.")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Try few settings of each method.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Show what accuracy costs: this scene by the thesis's fixed steps, by scipy's integrators and by labbook.

    Errors of depth, lift-off time, apex and cost against a reference, evaluations and times of each method at many
    settings; beside labbook's errors those that its error bars estimate, and how many misses these cover; and what 1 %
    of the cost in joules takes. Where jumps follow each other, four are made.

    Example: labbook sim accuracy --scene sim2 --set b_ad=100 --plot accuracy.png
    """
    from labbook.actions.simulate.pictures import save_plot
    from labbook.presenting.simulation.work_precision import as_data, as_lines, work_precision_of
    from reports.figures.kind import check_form
    from reports.figures.work_precision import draw_work_precision
    from simulator.accuracy.study import accuracy_study, n_points
    from simulator.changes import changed_by_words
    from simulator.scene_file import load_scene

    with progress("compiling", n_points(quick), shown=not as_json) as done:
        check_form("--plot", plot)
        study = accuracy_study(changed_by_words(load_scene(scene), sets or (), effects), quick, done)
        if plot is not None:
            save_plot(lambda: draw_work_precision(work_precision_of(study)), plot)
    files = {} if plot is None else {"plot": str(plot)}
    emit({**as_data(study), **files}, [*as_lines(study), *files.values()], as_json)


@app.command()
def effects(
    scene: SceneOption,
    within: Annotated[
        str, typer.Option("--within", metavar="SHARE", help="The change of cost, apex and depth that may pass.")
    ] = "1%",
    sets: SetOption = None,
    switched: Annotated[
        str | None, typer.Option("--effects", metavar="LIST", help="Effects on and off at first: +drag,-added_mass.")
    ] = None,
    accuracy: AccuracyOption = 1e-6,
    pairs: Annotated[bool, typer.Option("--pairs", help="Show every pair of effects, too.")] = False,
    timings: Annotated[
        bool, typer.Option("--timings", help="Compile and time a kernel without each effect: seconds for each.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Leave out each effect of a scene, alone and in pairs, and find the smallest set that is good enough.

    Good enough are cost, apex and depth within a share of those with all effects. Of a scene with many jumps the tenth
    is looked at. `labbook sim run --effects auto --within 1%` uses the set.

    Example: labbook sim effects --scene sim2 --within 1%
    """
    from dataclasses import asdict

    from data_schema.errors import UsageError
    from labbook.presenting.simulation import effects_ablation as shown
    from simulator.ablation.kernel_time import ablation_times
    from simulator.ablation.smallest import tolerance_of
    from simulator.ablation.study import ablation_of_effects, measured_scene, sets_to_leave_out
    from simulator.changes import changed_by_words, without_auto
    from simulator.scene_file import load_scene

    words, auto = without_auto(switched)
    if auto:
        raise UsageError("sim effects finds the smallest set of effects itself: leave auto out of --effects.")
    tolerance = tolerance_of(within, accuracy)
    full = changed_by_words(load_scene(scene), sets or (), words)
    tried = sets_to_leave_out(measured_scene(full))
    kernels = 2 + (sum(len(left_out) == 1 for left_out in tried) if timings else 0)
    if not as_json:
        typer.echo(shown.announcement(len(tried), kernels), err=True)
    with progress("effects", len(tried) + 1 + kernels, shown=not as_json) as step:
        ablation = ablation_of_effects(full, tolerance, accuracy, step)
        times = ablation_times(ablation, timings, step)
    head, *rows = shown.alone_table(ablation, times.without, times.full)
    lines = [*shown.heading(full, ablation), "", *columns(head, rows)]
    if pairs:
        head, *rows = shown.pairs_table(ablation)
        lines += ["", *columns(head, rows)]
    lines += ["", *shown.footnotes(ablation), "", *shown.verdict(ablation)]
    lines += shown.time_lines(times.full, times.smallest)
    emit({**shown.ablation_data(full, ablation), "times": asdict(times)}, lines, as_json)


@app.command()
def figures(
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="The folder to write to.")] = Path("thesis-figures"),
    form: Annotated[str, typer.Option("--format", metavar="KIND", help="png, pdf or svg.")] = "png",
    only: Annotated[
        list[str] | None, typer.Option("--only", metavar="NUMBER", help="This figure, such as 3.8; repeatable.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Reproduce the figures of the thesis's ch. 3, and hold its claims against what the simulation gives.

    Writes one file a figure, figures.md with the captions, and the claims as claims.csv and claims.md. Captions and
    claims are about all figures that the folder then holds, also those of an earlier call with other --only.

    Example: labbook sim figures --only 3.8 --format pdf --out paper
    """
    from labbook.actions.simulate.thesis_figures import THESIS_FIGURES, write_thesis_figures
    from labbook.presenting.simulation.published_results import claims_data, claims_table, short_rows

    with progress("figures", len(only or THESIS_FIGURES) + 1, shown=not as_json) as step:
        written = write_thesis_figures(out, form, only or (), step)
    head, *rows = short_rows(claims_table(written.findings))
    agreeing = sum(finding.agrees for finding in written.findings)
    data = {
        "figures": [
            {"number": item.figure.number, "title": item.figure.title, "file": str(item.file)}
            for item in written.figures
        ],
        "kept": [{"number": item.figure.number, "file": str(item.file)} for item in written.earlier],
        "captions": str(written.captions),
        "claims": claims_data(written.findings),
        "tables": [str(path) for path in written.tables],
        "agreeing": agreeing,
        "claims_in_all": written.claims_in_all,
    }
    lines = [f"figure {item.figure.number}: {item.file}" for item in written.figures]
    lines += [f"figure {item.figure.number}: {item.file}, from before" for item in written.earlier]
    lines.append(f"captions: {written.captions}")
    if rows:
        more = f"; without --only {written.claims_in_all} are judged" if len(rows) < written.claims_in_all else ""
        lines += ["", *columns(head, rows), "", f"{agreeing} of {len(rows)} claims hold at every point{more}."]
        lines.append(f"what each claim says, and all digits: {' and '.join(map(str, written.tables))}")
    emit(data, lines, as_json)


@app.command()
def published(
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="FILE", help="Write it as a document, too: a .md file.")
    ] = None,
    accuracy: AccuracyOption = 1e-6,
    as_json: JsonOption = False,
) -> None:
    """Simulate the published experiments on ground emulator, force plate and bed, and judge every published result.

    Shows the last of a hundred (eighty) jumps at each gain and the 24 conditions of the bed, the published number
    beside the simulated one; every result as reproduced, contradicted or not testable; what cannot be matched, and why;
    and which inputs are assumed.

    Example: labbook sim published --out published.md
    """
    from data_schema.errors import UsageError
    from labbook.presenting.simulation.published_experiments import as_data, document, notes, terminal_tables
    from simulator.steady.published_numbers import comparisons
    from simulator.steady.published_results import chapter_3_findings, judge_results, published_claims
    from simulator.steady.tables import STEPS, steady_tables
    from simulator.thesis.figures import ThesisFigures

    if out is not None and out.suffix != ".md":
        raise UsageError(f"--out {out} is no name for a document in Markdown: end it in .md.")

    with progress("experiments", STEPS + len(published_claims()), shown=not as_json) as step:
        tables = steady_tables(accuracy, step)
        compared = comparisons(tables)
        results = judge_results(chapter_3_findings(ThesisFigures(accuracy), step), compared, tables.bed)
    if out is not None:
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_text(document(tables, compared, results), encoding="utf-8")
    lines = []
    for title, (head, *rows) in terminal_tables(tables, compared, results).items():
        lines += [f"{title}:", *columns(head, rows), ""]
    lines += notes(tables, compared, results)
    files = {} if out is None else {"document": str(out)}
    emit({**as_data(tables, compared, results), **files}, [*lines, *files.values()], as_json)


app.command()(warm)
