"""`labbook sim figures`: the figures of the thesis's ch. 3, and its claims against the simulation."""

from pathlib import Path
from typing import Annotated

import typer

from labbook.cli.common import JsonOption, columns, emit, progress


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
    from labbook.actions.simulate.thesis_figures import write_thesis_figures
    from labbook.presenting.simulation.thesis_claims import claims_data, claims_rows
    from labbook.presenting.simulation.thesis_figures import THESIS_FIGURES

    with progress("figures", len(only or THESIS_FIGURES) + 1, shown=not as_json) as step:
        written = write_thesis_figures(out, form, only or (), step)
    head, *rows = claims_rows(written.findings)
    agreeing = sum(finding.agrees for finding in written.findings)
    data = {
        "figures": [
            {"number": item.figure.number, "title": item.figure.title, "file": str(item.file)}
            for item in written.figures
        ],
        "kept": [{"number": item.figure.number, "file": str(item.file)} for item in written.kept],
        "captions": str(written.captions),
        "claims": claims_data(written.findings),
        "tables": [str(path) for path in written.tables],
        "agreeing": agreeing,
        "claims_in_all": written.claims_in_all,
    }
    lines = [f"figure {item.figure.number}: {item.file}" for item in written.figures]
    lines += [f"figure {item.figure.number}: {item.file}, from before" for item in written.kept]
    lines.append(f"captions: {written.captions}")
    if rows:
        more = f"; without --only {written.claims_in_all} are judged" if len(rows) < written.claims_in_all else ""
        lines += ["", *columns(head, rows), "", f"{agreeing} of {len(rows)} claims agree{more}."]
        lines.append(f"what each claim says, and all digits: {' and '.join(map(str, written.tables))}")
    emit(data, lines, as_json)
