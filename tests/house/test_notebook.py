"""docs/from-book-to-figure.ipynb runs from its first cell to its last, on a book where it says that there is one."""

from __future__ import annotations

from pathlib import Path

import nbclient
import nbformat
import pytest

from tests.helpers.books import small_book

NOTEBOOK = Path(__file__).parents[2] / "docs" / "from-book-to-figure.ipynb"


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of the notebook's own machinery
def test_every_cell_runs_and_shows_something(tmp_path: Path) -> None:
    small_book(tmp_path / "demo-book")
    notebook = nbformat.read(NOTEBOOK, as_version=4)  # type: ignore[no-untyped-call]
    assert len(notebook.cells) <= 15
    nbclient.NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(tmp_path)}}).execute()
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    shown = [output for cell in code for output in cell.outputs if output.output_type != "stream"]
    assert len(shown) >= len(code)
    assert any("saved" in output.get("data", {}).get("text/html", "") for output in shown)
    assert "image/png" in code[-1].outputs[-1]["data"]
