"""`labbook sim`: the simulator; it needs no book."""

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from labbook.cli.common import PlotOption
from labbook.terminal import Shown, asking, columns, counted, progress, say, with_files

if TYPE_CHECKING:
    from simulator.scene import Scene

app = typer.Typer(no_args_is_help=True)


@dataclass(frozen=True, slots=True)
class Changed:
    """A scene and what is changed in it."""

    scene: Annotated[str, typer.Option(metavar="NAME", help="bed, sim1, sim2, emulator, force_plate, or a .toml file.")]
    sets: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="A parameter in SI units, or gain, flight, jumps, ...: see `labbook sim parts`; repeatable.",
        ),
    ] = None
    effects: Annotated[str | None, typer.Option(metavar="LIST", help="Effects on and off: +drag,-added_mass.")] = None

    def load(self) -> "Scene":
        """Return the scene with the changes."""
        from simulator.changes import changed_by_words
        from simulator.scene_file import load_scene

        return changed_by_words(load_scene(self.scene), self.sets or (), self.effects)


AccuracyOption = Annotated[float, typer.Option("--accuracy", help="The relative error aimed at.")]
COMPILING = "compiling for up to 30 s, once"


@app.command()
def run(
    scene: Changed,
    accuracy: AccuracyOption = 1e-6,
    plot: PlotOption = None,
    error_bars: Annotated[
        bool, typer.Option("--error-bars/--no-error-bars", help="Simulate a second time, a hundred times finer.")
    ] = True,
) -> Shown:
    """Simulate a scene and show its jump: times, heights, joules, how sure they are and what they rest on.

    Each number has an estimated error: the difference to a simulation a hundred times finer, whose values are shown.
    Of a scene with many jumps each has a line, and the last one is shown in full, and drawn. --json gives every change
    of the contact mode by the kernel's names and, beside them, by those of the ground, as in the plot.

    Example: labbook sim run --scene sim2 --set b_ad=100 --effects +drag --accuracy 1e-8 --plot jump.png
    """
    from labbook.presenting.simulation.simulated import as_data, as_lines, figure_title, mode_name
    from reports.figures.kind import check_form, write_figure
    from reports.figures.trajectory import draw_trajectory
    from simulator.error_bars import simulate_with_errors
    from simulator.jump import simulate
    from simulator.kernel.build import is_compiled

    check_form("--plot", plot)
    changed = scene.load()
    simulated = simulate_with_errors if error_bars else simulate
    first = "" if is_compiled(changed.effects) else f"; where it takes long, {COMPILING}"
    with progress(f"simulating{first}", None):
        result = simulated(changed, accuracy, trajectory=plot is not None)
        if plot is not None:
            write_figure(draw_trajectory(result, figure_title(result), partial(mode_name, changed)), plot)
    return with_files(as_data(result), as_lines(result), {"plot": plot})


@app.command()
def sweep(
    scene: Changed,
    over: Annotated[
        list[str],
        typer.Option(
            metavar="NAME=VALUES",
            help="What to sweep: LOW:HIGH:COUNT[:log] or VALUE,VALUE; for a sample LOW:HIGH[:log]; repeatable.",
        ),
    ],
    out: Annotated[Path, typer.Option(metavar="FILE", help="The result: a .nc file or a .zarr folder.")],
    sobol: Annotated[
        int | None,
        typer.Option(metavar="COUNT", help="Draw so many scenes (best a power of 2) from the ranges."),
    ] = None,
    seed: Annotated[int | None, typer.Option(help="Another seed draws another sample; 0 without it.")] = None,
    accuracy: AccuracyOption = 1e-6,
    error_bars: Annotated[
        bool | None,
        typer.Option(
            "--error-bars/--no-error-bars",
            help="Simulate all scenes, or none, a second time, a hundred times finer; else 5 % of them.",
        ),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(metavar="URL", help="A Dask cluster's scheduler, tcp://HOST:PORT, to compute on."),
    ] = None,
) -> Shown:
    """Simulate a scene over a grid, or a Sobol sample, of its parameters, on all cores, to an xarray Dataset in a file.

    A value outside its parameter's range is refused at once. Where values are in range but do not fit together, the
    sweep goes on without those scenes: it says how many they are and why, and in the file their outcome is refused and
    their numbers are NaN.

    The errors of 5 % of the scenes, at least about 20, are estimated by a simulation a hundred times finer: how many do
    not keep the accuracy is said, and error_over_accuracy in the file has them. With --error-bars the file has the
    finer values of all scenes, as labbook sim run shows them, and an estimated error of each in a column NAME_error;
    ill_conditioned is then by these.

    Interrupted or killed, the same command goes on where it was; until the file is whole, FILE.part holds what is done.

    Example: labbook sim sweep --scene sim2 --over b_ad=0:300:31 --over foot_radius=0.02,0.03,0.038 --out sweep.nc
    """
    import importlib.metadata

    from labbook.presenting.simulation.swept import as_data, as_lines
    from simulator.kernel.build import is_compiled
    from simulator.sweep.chunks import why_scalar
    from simulator.sweep.run import cluster, run_sweep, threads
    from simulator.sweep.sweep import SAMPLED, sweep_by_words

    asked = sweep_by_words(
        scene.scene,
        over,
        scene.sets or (),
        scene.effects,
        accuracy=accuracy,
        sample=sobol,
        seed=seed,
        error_bars=SAMPLED if error_bars is None else float(error_bars),
        labbook=importlib.metadata.version("robot-labbook"),
    )
    if asked.why_refused and asking():
        say(f"note: {asked.why_refused}", err=True)
    lanes = why_scalar(asked.scene, asked.design) is None
    here = scheduler is None and not is_compiled(asked.scene.effects, lanes=lanes)
    first = f" after {COMPILING}" if here else ""
    with (
        counted(f"sweeping{first}", asked.jumps_wanted, "jumps") as advance,
        threads() if scheduler is None else cluster(scheduler) as computing,
    ):
        done = run_sweep(asked, out, computing, advance)
    return Shown(as_data(done), as_lines(done))


@app.command()
def falsify(
    scene: Changed,
    over: Annotated[
        list[str],
        typer.Option(
            metavar="NAME=LOW:HIGH",
            help="A range of the box; by logarithm from a decade on, or where :log follows; repeatable.",
        ),
    ],
    claim: Annotated[str, typer.Option(metavar="CLAIM", help="What is to be refuted: saves.")] = "saves",
    equal: Annotated[
        str, typer.Option(metavar="WHAT", help="Compare joules at equal height, or equal gains.")
    ] = "height",
    grounds: Annotated[
        int, typer.Option(metavar="COUNT", help="Grounds in the sample, best a power of 2.", min=8, max=1_000_000)
    ] = 2048,
    seed: Annotated[int, typer.Option(help="Another seed draws another sample.")] = 0,
    accuracy: AccuracyOption = 1e-6,
    plot: PlotOption = None,
) -> Shown:
    """Look for grounds on which active damping does not save, and draw the boundary.

    On each ground of a Sobol sample of the box the scene's jump is made with its active damping (a gain of 150 where it
    has none) and without. By default the one that jumps higher is given a softer extension until both reach the same
    apex; where it then does not jump, the other a stiffer one. Differential evolution goes on from the worst grounds.
    The worst ground and others far from it are simulated with error bars and by another solver. Grounds where nothing
    can be compared, or whose jumps are flagged, are counted apart.

    Example: labbook sim falsify --scene bed --claim saves --over kg_scale=0.1:100 --over bg_scale=0.03:10 --plot f.png
    """
    from labbook.presenting.simulation.falsified import as_data, as_lines, title
    from reports.figures.boundary import draw_boundary
    from reports.figures.kind import check_form, write_figure
    from simulator.falsify import counterexamples, question_by_words
    from simulator.falsify import falsify as search

    check_form("--plot", plot)
    question = question_by_words(
        scene.scene,
        over,
        scene.sets or (),
        scene.effects,
        claim=claim,
        equal=equal,
        grounds=grounds,
        seed=seed,
        accuracy=accuracy,
    )
    with progress("simulating the sample", None) as step:
        found = search(question, step)
        step("confirming what was found")
        examples = counterexamples(question, found)
        if plot is not None:
            write_figure(draw_boundary(question, found, examples, title(question)), plot)
    return with_files(as_data(question, found, examples), as_lines(question, found, examples), {"plot": plot})


@app.command()
def parts(
    name: Annotated[
        str | None, typer.Argument(help="An effect, a parameter or a word; without it, all of them.")
    ] = None,
    markdown: Annotated[
        bool, typer.Option("--markdown", help="Print the tables as Markdown, as docs/scenes.md has them.")
    ] = False,
) -> Shown:
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
        return Shown(part_data(name), part_lines(name))
    lines = parts_markdown().splitlines()
    if not markdown:
        lines = []
        for table in parts_tables().values():
            head, *rows = table.texts
            lines += [table.caption, "", *columns(head, rows), ""]
        lines.append("labbook sim parts NAME says more of one of them.")
    return Shown(parts_data(), lines)


@app.command()
def accuracy(
    scene: Changed,
    plot: PlotOption = None,
    quick: Annotated[bool, typer.Option("--quick", help="Try few settings of each method.")] = False,
) -> Shown:
    """Show what accuracy costs: this scene by the thesis's fixed steps, by scipy's integrators and by labbook.

    Errors of depth, lift-off time, apex and cost against a reference, evaluations and times of each method at many
    settings; and what 1 % of the cost in joules takes. Where jumps follow each other, four are made.

    Example: labbook sim accuracy --scene sim2 --set b_ad=100 --plot accuracy.png
    """
    from labbook.presenting.simulation.work_precision import as_data, as_lines, figure_notes, figure_title
    from reports.figures.kind import check_form, write_figure
    from reports.figures.work_precision import draw_work_precision
    from simulator.accuracy.study import accuracy_study, n_points

    with progress("compiling", n_points(quick)) as done:
        check_form("--plot", plot)
        study = accuracy_study(scene.load(), quick, done)
        if plot is not None:
            write_figure(draw_work_precision(study, figure_title(study), figure_notes(study)), plot)
    return with_files(as_data(study), as_lines(study), {"plot": plot})


@app.command()
def effects(
    scene: Changed,
    within: Annotated[
        str, typer.Option(metavar="SHARE", help="The change of cost, apex and depth that may pass.")
    ] = "1%",
    accuracy: AccuracyOption = 1e-6,
) -> Shown:
    """Leave out each effect of a scene, and find out which are enough.

    Enough are those with which cost, apex and depth stay within a share of those with all effects; the others are left
    out one after the other, always the one that changes least. Of a scene with many jumps the tenth is looked at.

    Example: labbook sim effects --scene sim2 --within 1%
    """
    from labbook.presenting.simulation.effects import as_data, as_lines
    from simulator.ablation import ablation_of_effects, tolerance_of

    tolerance = tolerance_of(within, accuracy)
    full = scene.load()
    with progress("simulating", None) as step:
        ablation = ablation_of_effects(full, tolerance, accuracy, step)
    return Shown(as_data(full, ablation), as_lines(full, ablation))


@app.command()
def figures(
    out: Annotated[Path, typer.Option(metavar="DIR", help="The folder to write to.")] = Path("thesis-figures"),
    form: Annotated[str, typer.Option("--format", metavar="KIND", help="png, pdf or svg.")] = "png",
    only: Annotated[
        list[str] | None, typer.Option(metavar="NUMBER", help="This figure, such as 3.8; repeatable.")
    ] = None,
) -> Shown:
    """Reproduce the figures of the thesis's ch. 3, and hold its claims against what the simulation gives.

    Writes one file a figure, figures.md with the captions, and the claims as claims.csv and claims.md.

    Example: labbook sim figures --only 3.8 --format pdf --out paper
    """
    from labbook.actions.simulate.thesis_figures import THESIS_FIGURES, write_thesis_figures
    from labbook.presenting.simulation.published import claims_data

    with progress("figures", len(only or THESIS_FIGURES) + 1) as step:
        written = write_thesis_figures(out, form, only or (), step)
    contradicted = [finding.claim.id for finding in written.findings if not finding.agrees]
    agreeing = len(written.findings) - len(contradicted)
    data = {
        "figures": [
            {"number": number, "title": THESIS_FIGURES[number].title, "file": file}
            for number, file in written.figures.items()
        ],
        "captions": written.captions,
        "claims": claims_data(written.findings),
        "tables": written.tables,
        "agreeing": agreeing,
    }
    lines = [f"figure {number}: {file}" for number, file in written.figures.items()]
    lines.append(f"captions: {written.captions}")
    if written.findings:
        lines.append(f"{agreeing} of {len(written.findings)} claims hold at every point: {written.tables[1]}")
        lines += [f"not everywhere: {', '.join(contradicted)}"] if contradicted else []
    return Shown(data, lines)


@app.command()
def published(
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE", help="Write it to a .md file.")] = None,
    accuracy: AccuracyOption = 1e-6,
) -> Shown:
    """Simulate the published experiments on ground emulator, force plate and bed, and judge every published result.

    Shows the last of a hundred (eighty) jumps at each gain and the 24 conditions of the bed, the published number
    beside the simulated one; every result as reproduced, contradicted, dependent on what was
    never published, or not testable; what cannot be matched, and why;
    and which inputs are assumed: as Markdown, with --out in a file.

    Example: labbook sim published --out published.md
    """
    from data_schema.errors import UsageError
    from labbook.presenting.simulation.published import as_data, document
    from simulator.steady.published_results import judge_results
    from simulator.steady.tables import STEPS, steady_tables
    from simulator.thesis.claims import chapter_3_findings, experiment_findings
    from simulator.thesis.figures import ThesisFigures
    from simulator.thesis.readings import met_by_others, set_1_readings

    if out is not None and out.suffix != ".md":
        raise UsageError(f"--out {out} is no name for a document in Markdown: end it in .md.")

    with progress("experiments", STEPS + 1) as step:
        tables = steady_tables(accuracy, step)
        findings = experiment_findings(tables)
        figures = ThesisFigures(accuracy)
        readings = set_1_readings(figures)
        chapter_3 = chapter_3_findings(figures)
        results = judge_results((*chapter_3, *findings), tables.bed, met_by_others(readings))
        step("chapter 3")
    text = document(tables, findings, results, readings)
    if out is not None:
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_text(text, encoding="utf-8")
    lines = text.splitlines() if out is None else []
    return with_files(as_data(tables, findings, results, readings), lines, {"document": out})


@app.command()
def grains(
    scene: Changed,
    diameter: Annotated[
        list[float] | None, typer.Option(metavar="M", help="Mean diameter of grains; repeatable. 0.01 and 0.014 m.")
    ] = None,
    seeds: Annotated[int, typer.Option(min=1, max=20, help="Beds of each diameter.")] = 3,
    grain: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE",
            help="Of grains and bed, in SI units: young_modulus, poisson_ratio, restitution, friction, "
            "rolling_friction, width, depth; repeatable.",
        ),
    ] = None,
    plot: PlotOption = None,
) -> Shown:
    """Let the foot of a jump into beds of grains, with and without active damping: what do the grains take up?

    Discrete elements (thesis 3.2.4, figure 3.10): grains that push, rub and roll on each other, and a foot that follows
    the jump that labbook sim run simulates on its bulk model. Shown are the grains' kinetic energy, the foot's work on
    them, and their scatter over beds.

    Settled beds are kept; the first time they take as long as the jumps, a minute each on two cores.

    Example: labbook sim grains --scene bed --set damping_gain=150 --plot grains.png
    """
    from labbook.presenting.simulation.grains import as_data, as_lines
    from reports.figures.grains import draw_grains
    from reports.figures.kind import check_form, write_figure
    from simulator.grains.bed import bed_by_words
    from simulator.grains.foot import DIAMETERS_M, jumps_on_grains

    check_form("--plot", plot)
    diameters_m = tuple(dict.fromkeys(diameter or DIAMETERS_M))
    with progress("compiling", 1 + 3 * seeds * len(diameters_m)) as step:
        study = jumps_on_grains(scene.load(), bed_by_words(grain or ()), diameters_m, seeds, step=step)
        if plot is not None:
            write_figure(draw_grains(study), plot)
    return with_files(as_data(study), as_lines(study), {"plot": plot})


@app.command()
def warm(
    scenes: Annotated[
        list[str] | None, typer.Argument(metavar="[SCENE]...", help="Names or .toml files; without any, all shipped.")
    ] = None,
    lanes: Annotated[
        bool, typer.Option("--lanes", help="Also compile sweeps that simulate many scenes side by side: 50 s each.")
    ] = False,
) -> Shown:
    """Compile the simulator for the effects of scenes: 10 to 30 s each, once for each version of labbook.

    Nothing needs it: a first simulation runs in plain Python for 10 s before it compiles. Sweeps, reports and anything
    with many jumps then start at once. With --lanes sweeps of these scenes take half the time, to the same numbers;
    scenes that have no lanes are left out.

    Example: labbook sim warm sim2 bed --lanes
    """
    from data_schema.errors import UsageError
    from data_schema.file_cache import CACHE_VARIABLE
    from simulator.kernel.build import is_cached, kernel_for, why_no_lanes
    from simulator.scene_file import load_scene, shipped_scenes

    found = {name: load_scene(name) for name in scenes or shipped_scenes()}
    spent_s: dict[str, float] = {}
    with progress("compiling", len(found)) as done:
        for name, scene in found.items():
            spent_s[name] = kernel_for(scene.effects).compile_time_s
            if lanes and why_no_lanes(scene.effects) is None:
                spent_s[name] += kernel_for(scene.effects, lanes=True).compile_time_s
            done(name)
            if not is_cached(scene.effects):
                raise UsageError(
                    f"the kernel of {name} was compiled and cannot be kept: name a folder that can be written in "
                    f"{CACHE_VARIABLE}."
                )
    return Shown({"compile_time_s": spent_s}, [f"{name}: ready after {spent:.3g} s" for name, spent in spent_s.items()])
