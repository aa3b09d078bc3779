import re

import pytest

from data_schema.vocabulary import Undefined
from reports.tables.as_latex import latex_bytes, latex_text
from reports.tables.registry import TABLES
from reports.tables.table import Column, Row, Table, value_cell, words


def test_every_special_character_is_escaped():
    assert latex_text(r"50 % of A&B_1 {#$} ~^ \x <a> |") == (
        r"50 \% of A\&B\_1 \{\#\$\} \textasciitilde{}\textasciicircum{} \textbackslash{}x \textless{}a\textgreater{}"
        r" \textbar{}"
    ).replace("} \\textasciitilde{}\\textasciicircum{} ", "} \\textasciitilde{}\\textasciicircum{} ")
    assert latex_text("−1 ± 2\u00a0J") == r"\ensuremath{-}1 \ensuremath{\pm} 2~J"


@pytest.mark.parametrize("name", TABLES)
def test_every_table_is_balanced(content, name):
    table = TABLES[name].make(content)
    text = latex_bytes(table).decode("utf-8")
    assert re.findall(r"\\begin\{(\w+)\}", text) == re.findall(r"\\end\{(\w+)\}", text)[::-1]
    bare = re.sub(r"\\[{}]", "", text)
    assert bare.count("{") == bare.count("}")
    for rule in (r"\toprule", r"\midrule", r"\bottomrule"):
        assert text.count(rule) == 1
    rows = [line for line in text.splitlines() if line.endswith(r"\\") and "multicolumn" not in line]
    cells = {len(re.findall(r"(?<!\\)&", row)) for row in rows if not row.startswith(r"\caption")}
    assert cells == {len(table.heads) - 1}


def test_units_stand_in_the_heads(content):
    text = latex_bytes(TABLES["joules_by_condition"].make(content)).decode("utf-8")
    assert "mean (J) & SD (J) & SE (J)" in text
    assert "d (kg/s) & gain" in text


def test_a_dash_with_a_footnote_for_what_does_not_exist():
    columns = (Column("a", ("a",), numeric=False), Column("b", ("b",), "J"))
    rows = (Row((words("x"), value_cell(Undefined("no 100 % sample")))), Row((words("y"), value_cell(1.5, 1))))
    text = latex_bytes(Table("t", "Caption", columns, rows)).decode("utf-8")
    assert r"x & --\textsuperscript{a} \\" in text
    assert r"\textsuperscript{a}~no 100 \% sample" in text


def test_a_table_longer_than_a_page_is_a_longtable(content):
    assert rb"\begin{longtable}" in latex_bytes(TABLES["run_values"].make(content))


def test_a_bracket_does_not_become_an_argument():
    table = Table("t", "", (Column("a", ("a",)),), (Row((words("[2 runs]"),)),))
    assert r"{}[2 runs] \\" in latex_bytes(table).decode("utf-8")
