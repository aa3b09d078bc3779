"""The numbers of page one for a paper: each is the report's own, rounded as the report rounds it."""

import dataclasses
import re
import shutil
import subprocess

import pytest

from reports.numbers import Number
from reports.tables.formats import macro_name, macros_bytes, macros_of
from tests.reports.made import overall_savings

PDFLATEX = shutil.which("pdflatex")
LINE = re.compile(r"\\newcommand\{\\(\w+)\}\{(.*)\}(?: % (\w+))?")


@pytest.fixture(scope="module")
def with_overall(content):
    saved = Number(11.234, "%", se=1.41, ci_low=8.12, ci_high=14.31, provenance="0abc123")
    groups = tuple(each.group for each in content.pooled[:4])
    overall = overall_savings(saved, groups, days=("2021-05-03", "2021-05-04"))
    return dataclasses.replace(content, overall=(overall,))


def parsed(data):
    """Name -> text as LaTeX prints it, and the id behind it."""
    lines = [line for line in data.decode("utf-8").splitlines() if not line.startswith("%")]
    found = {}
    for line in lines:
        name, text, identity = LINE.fullmatch(line).groups()
        text = text.replace("~", " ").replace(r"\%", "%").replace(r"\ensuremath{-}", "-")
        found[name] = (text.replace(r"\textless{}", "<"), identity or "")
    assert len(found) == len(lines), "each name once"
    return found


def test_every_macro_is_the_number_of_the_report(with_overall):
    found = parsed(macros_bytes(with_overall))
    assert all(re.fullmatch(r"labbook[A-Za-z]+", name) for name in found)
    for comparison in with_overall.pooled:
        lead = comparison.decision
        group = " ".join(f"{factor} {level}" for factor, level in comparison.group.items())
        number = lead.savings or lead.difference
        what = "saving" if lead.savings else "difference"
        factor = 1.0 if lead.savings else 1000.0
        name = macro_name(comparison.quantity.key, group, what)
        for end, value in (("", number.value), ("Low", number.ci_low), ("High", number.ci_high)):
            text, identity = found[name + end]
            digits = text.split()[0]
            half_a_digit = 0.51 * 10.0 ** -len(digits.partition(".")[2])
            assert float(digits) == pytest.approx(value * factor, abs=half_a_digit)
            assert identity == number.provenance
        assert found[macro_name(comparison.quantity.key, group, "runs control")][0] == str(lead.n_control)


def test_the_overall_saving_comes_with_interval_p_and_days(with_overall):
    found = parsed(macros_bytes(with_overall))
    assert found["labbookOverallSaving"] == ("11.2 %", "0abc123")
    assert found["labbookOverallSavingInterval"] == ("8.1 to 14.3 %", "0abc123")
    assert found["labbookOverallSavingP"][0] == "p < .001"
    assert found["labbookOverallSavingDays"][0] == "2"
    assert found["labbookRunsDone"][0] == str(with_overall.flow.runs_done)


def test_each_level_that_the_plan_compares_has_its_numbers_and_an_exploratory_one_has_none(with_overall):
    levels = [each for each in with_overall.comparisons if not each.opens]
    first = dataclasses.replace(levels[0], exploratory="")
    others = [dataclasses.replace(each, exploratory="pooled by plan") for each in levels[1:]]
    found = parsed(macros_bytes(dataclasses.replace(with_overall, comparisons=(first, *others))))
    group = " ".join(f"{factor} {level}" for factor, level in first.group.items())
    (swept,) = [factor.name for factor in with_overall.factors if factor.swept]
    name = macro_name(first.quantity.key, group, f"{swept} {first.level}")
    assert found[f"{name}DifferenceP"][1] == first.decision.difference.provenance
    assert found[f"{name}RunsControl"][0] == str(first.decision.n_control)
    assert all(
        each.startswith((name, "labbookContrast", "labbookOverall", "labbookRuns", "labbookJumps", "labbookDays"))
        for each in found
    )


def test_names_are_letters_and_each_stands_for_one_number(with_overall):
    assert macro_name("joules", "k_gain 300", "mass -1.5") == "labbookJoulesKGainThreeZeroZeroMassMinusOnePointFive"
    pooled = [each for each in with_overall.comparisons if each.opens][:1]
    twice = [dataclasses.replace(pooled[0], group={"foot": level}) for level in ("a b", "a_b")]
    names = [macro.name for macro in macros_of(dataclasses.replace(with_overall, comparisons=tuple(twice)))]
    assert len(names) == len(set(names))


def test_macros_lie_beside_the_page(written, content):
    assert (written.parent / "numbers.tex").read_bytes() == macros_bytes(content)


@pytest.mark.skipif(PDFLATEX is None, reason="pdflatex is not installed: the macros are not compiled")
def test_latex_knows_every_macro_wherever_it_stands(with_overall, tmp_path):
    (tmp_path / "numbers.tex").write_bytes(macros_bytes(with_overall))
    uses = [rf"\{macro.name}{{}}" for macro in macros_of(with_overall)]
    places = [
        rf"\section{{Of {use} in a title}} {use}"
        rf"\begin{{figure}}\caption[short: {use}]{{In a caption: {use}}}\end{{figure}}"
        rf"\begin{{table}}\caption{{{use}}}"
        rf"\begin{{tabular}}{{lr}}{use} & {use}\footnote{{{use}}}\\\end{{tabular}}\end{{table}}"
        r"\clearpage"
        for use in uses
    ]
    lists = r"\tableofcontents\listoffigures\listoftables"
    head = r"\documentclass{article}\usepackage{hyperref}\input{numbers}"
    source = rf"{head}\begin{{document}}{lists}{chr(10).join(places)}\end{{document}}"
    (tmp_path / "paper.tex").write_text(source, encoding="utf-8")
    command = [PDFLATEX, "-interaction=nonstopmode", "-halt-on-error", "-no-shell-escape", "paper.tex"]
    for _pass in range(2):  # the lists are read in the second
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, timeout=120, check=False)
        assert done.returncode == 0, done.stdout[-2000:]
