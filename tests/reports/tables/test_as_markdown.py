from __future__ import annotations

from reports.tables.formats import markdown_text
from reports.tables.table import Cell, Column, Row, Table, words

TABLE = Table(
    "own",
    "A caption.",
    (Column("name", ("name",), numeric=False), Column("mean", ("mean",), "J"), Column("raw", ("raw",), shown=False)),
    (
        Row((words("a|b"), Cell("1.0", (1.0,)), words("hidden"))),
        Row((words("c"), Cell("2.0", (2.0,)), words("hidden")), strong=True),
    ),
)


def test_caption_heads_with_units_and_rows() -> None:
    assert markdown_text(TABLE).splitlines() == [
        "A caption.",
        "",
        "| name | mean (J) |",
        "|---|---|",
        "| a\\|b | 1.0 |",
        "| c | **2.0** |",
    ]


def test_a_notebook_shows_the_columns_of_a_table_that_are_shown() -> None:
    shown = TABLE._repr_html_()
    assert "<caption>A caption.</caption>" in shown
    assert "<th>name</th><th>mean (J)</th></tr>" in shown
    assert shown.count("<tr>") == 3
    assert "<td>a|b</td><td>1.0</td>" in shown
    assert "hidden" not in shown
