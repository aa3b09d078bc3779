import re
import shutil
import subprocess

import pytest

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from reports.tables.formats import latex_bytes, latex_text
from reports.tables.registry import TABLES
from reports.tables.table import Column, Row, Table, value_cell, words
from tests.helpers.pages import TABLE_NAMES
from tests.helpers.wording import says


def test_every_special_character_is_escaped():
    assert latex_text(r"50 % of A&B_1 {#$} ~^ \x <a> | `b`") == (
        r"50 \% of A\&B\_1 \{\#\$\} \textasciitilde{}\textasciicircum{} \textbackslash{}x \textless{}a\textgreater{}"
        r" \textbar{} \textasciigrave{}b\textasciigrave{}"
    )
    assert latex_text("--no ---x") == "-{}-no -{}--x"
    assert latex_text("−1 ± 2\u00a0J") == r"\ensuremath{-}1 \ensuremath{\pm} 2~J"
    assert latex_text("10⁻⁹ m²") == r"10\ensuremath{^{-9}} m\ensuremath{^{2}}"


@pytest.mark.parametrize("name", TABLE_NAMES)
def test_every_table_is_balanced(content, name):
    table = TABLES[name].make(content)
    text = latex_bytes(table).decode("utf-8")
    assert re.findall(r"\\begin\{(\w+)\}", text) == re.findall(r"\\end\{(\w+)\}", text)[::-1]
    bare = re.sub(r"\\[{}]", "", text)
    assert bare.count("{") == bare.count("}")
    heads = 2 if "longtable" in text.splitlines()[0] else 1
    assert [text.count(rule) for rule in (r"\toprule", r"\midrule", r"\bottomrule")] == [heads, heads, 1]
    rows = [line.split(" % ")[0] for line in text.splitlines() if "multicolumn" not in line and r"\caption" not in line]
    cells = {len(re.findall(r"(?<!\\)&", row)) for row in rows if row.endswith(r"\\")}
    ids = any(column.fields == ("provenance",) for column in table.heads)
    assert cells == {len(table.heads) - 1 - ids}


def test_a_provenance_id_is_a_comment_beside_its_row(content):
    table = TABLES["joules_by_condition"].make(content)
    text = latex_bytes(table).decode("utf-8")
    for row in table.rows:
        assert re.search(rf"\\\\ % {row.cells[-1].text}$", text, re.MULTILINE)
    assert r"\\ %" not in latex_bytes(TABLES["provenance"].make(content)).decode("utf-8")


def test_a_dash_with_a_footnote_for_what_does_not_exist():
    columns = (Column("a", ("a",), numeric=False), Column("b", ("b",), "J"))
    rows = (
        Row((words("x"), value_cell(Undefined(Reason.AS_SAID, said="no 100 % sample")))),
        Row((words("y"), value_cell(1.5, 1))),
    )
    text = latex_bytes(Table("t", "Caption", columns, rows)).decode("utf-8")
    says(text, "x & \\textendash{}\\textsuperscript{a}")
    says(text, "100", "\\% sample")


def test_a_table_longer_than_a_page_is_a_longtable(content):
    assert rb"\begin{longtable}" in latex_bytes(TABLES["each_run"].make(content))


def test_a_bracket_does_not_become_an_argument():
    table = Table("t", "", (Column("a", ("a",)),), (Row((words("[2 runs]"),)),))
    assert r"{}[2 runs] \\" in latex_bytes(table).decode("utf-8")


def test_words_break_their_lines_and_numbers_do_not():
    columns = (Column("a", ("a",), numeric=False, prose=True), Column("b", ("b",), "J"))
    narrow = latex_bytes(Table("t", "", columns, (Row((words("two words"), value_cell(1.5, 1))),))).decode("utf-8")
    assert r"\begin{tabular}{@{}lr@{}}" in narrow
    wide = latex_bytes(Table("t", "", columns, (Row((words("many words " * 20), value_cell(1.5, 1))),))).decode("utf-8")
    assert re.search(r"\\begin\{tabular\}\{@\{\}>\{\\raggedright\\arraybackslash\}p\{0\.\d+\\linewidth\}r@", wide)


PDFLATEX = shutil.which("pdflatex")
NASTY = '50 % of A&B_1 {#$} ~^ \\x <a> | [b] `c` "d" --e -- f* ± ² × ° ∞ − – é ß\u00a0… αβγτω ΔΩΑ m³'
DOCUMENT = r"""\documentclass{article}
\usepackage[utf8]{inputenc}
\usepackage{PACKAGES}
\begin{document}
TABLES
\end{document}
"""


def compiled(folder, tables):
    """Compile tables with no more packages than they name; return what LaTeX says of them."""
    texts = [latex_bytes(table).decode("utf-8") for table in tables]
    packages = {name for text in texts for name in re.match(r"% needs \\usepackage\{(.*)\}", text)[1].split(", ")}
    body = "\\clearpage\n".join(texts)
    source = DOCUMENT.replace("PACKAGES", ",".join(sorted(packages))).replace("TABLES", body)
    (folder / "all.tex").write_text(source, encoding="utf-8")
    command = [PDFLATEX, "-interaction=nonstopmode", "-halt-on-error", "-no-shell-escape", "all.tex"]
    done = subprocess.run(command, cwd=folder, capture_output=True, timeout=120, check=False)
    log = done.stdout.decode("utf-8", "replace")
    assert done.returncode == 0, log[-2000:]
    return log


@pytest.mark.skipif(PDFLATEX is None, reason="pdflatex is not installed: the LaTeX tables are not compiled")
def test_latex_prints_every_table_within_its_page(content, minimal, tmp_path):
    log = compiled(tmp_path, [kind.make(given) for given in (content, minimal) for kind in TABLES.values()])
    assert "Missing character" not in log
    assert "Float too large" not in log
    over_pt = [float(size) for size in re.findall(r"Overfull \\hbox \(([\d.]+)pt", log)]
    assert max(over_pt, default=0.0) < 30.0  # a table stands out of its column by more than 5 mm at each side


@pytest.mark.skipif(PDFLATEX is None, reason="pdflatex is not installed: the LaTeX tables are not compiled")
def test_latex_prints_any_name_as_it_is(tmp_path):
    columns = (Column(NASTY, ("a",), numeric=False, prose=True), Column("b", ("b",), NASTY))
    rows = tuple(
        Row((words(name), value_cell(Undefined(Reason.AS_SAID, said=NASTY))), block=NASTY)
        for name in (NASTY, f"[{NASTY}", NASTY * 30)
    )
    compiled(tmp_path, [Table("a_b", NASTY, columns, rows), Table("long", NASTY, columns, rows * 20)])
