"""A result in a notebook: small, escaped, and what is undefined has its reason."""

from __future__ import annotations

from data_schema.notebook import MOST_ROWS, fields_html, table_html


def test_a_table_is_escaped_and_cut_where_it_is_long() -> None:
    shown = table_html(["<a>"], [["<b>&"]] * (MOST_ROWS + 5), caption='"c"')
    assert shown.startswith("<table><caption>&quot;c&quot;</caption><thead><tr><th>&lt;a&gt;</th>")
    assert shown.count("<td>&lt;b&gt;&amp;</td>") == MOST_ROWS
    assert shown.endswith("<p>5 more rows</p>")


def test_fields_are_rounded_and_told_why_they_are_missing() -> None:
    data = {"mean": 12.34567, "p": None, "p_reason": "n < 2", "ok": True, "parts": [1, 2]}
    shown = fields_html(data, sentence="a < b.")
    assert shown.startswith("<p>a &lt; b.</p><details>")
    for cells in ("mean</td><td>12.35", "p</td><td>\u2013 (n &lt; 2)", "ok</td><td>yes"):
        assert cells in shown
    assert "parts" not in shown
    assert "p_reason" not in shown
