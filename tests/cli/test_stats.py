"""`labbook stats` on tables: real files, the numbers of `stats`, what is missing, undefined or refused."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

from labbook.actions.stats.answering import Answer, Question, compare, equal
from labbook.analysis.observations import Observation, Observations
from stats.compare.two_sample import compare_two
from stats.days.decision import contrast_by_day
from stats.groups.anova import one_way_anova, welch_anova
from stats.groups.tukey import compare_all_pairs
from stats.results import as_dict
from tests.cli.shell import good, labbook, refused
from tests.helpers.wording import says

CE = ("16.31", "15.9", "17.05", "16.6", "15.2")
AD = ("14.2", "13.9", "14.45", "13.1", "14.9")
DAYS = ("1", "1", "2", "2", "3")
BY = ("--value", "energy_J", "--by", "controller", "--control", "CE")


def written(folder: Path, lines: Sequence[str], name: str = "data.csv") -> Path:
    path = folder / name
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def table(folder: Path, groups: Mapping[str, Sequence[str]], sep: str = ",", days: Sequence[str] = DAYS) -> Path:
    cells = [(name, *pair) for name, values in groups.items() for pair in zip(values, days, strict=False)]
    return written(folder, [sep.join(row) for row in (("controller", "energy_J", "date"), *cells)])


def floats(values: Sequence[str]) -> list[float]:
    return [float(value) for value in values]


def found(result: Any) -> Any:
    """A result as JSON gives it back, every digit kept."""
    return json.loads(json.dumps(as_dict(result)))


@pytest.fixture
def data(tmp_path: Path) -> Path:
    return table(tmp_path, {"CE": CE, "AD": AD})


def run(path: Path, *words: str) -> Any:
    return good(labbook("stats", words[0], path, *words[1:], "--json", at=path.parent)).json


def test_json_holds_the_results_of_stats_unrounded(data: Path) -> None:
    ce, ad = floats(CE), floats(AD)
    (compared,) = run(data, "compare", *BY, "--alpha", "0.1")["comparisons"]
    assert compared == {"a": "AD", "b": "CE", **found(compare_two(ad, ce, alpha=0.1, names=("AD", "CE")))}
    (thesis,) = run(data, "compare", *BY, "--route", "f_then_t")["comparisons"]
    assert thesis == {"a": "AD", "b": "CE", **found(compare_two(ad, ce, "f_then_t", names=("AD", "CE")))}
    groups = {"CE": ce, "AD": ad}
    several = run(data, "anova", *BY)
    assert several["welch"] == found(welch_anova(groups))
    assert several["pairs"] == found(compare_all_pairs(groups, variances="unequal"))
    assert several["variances"]["test"] == "Brown-Forsythe"
    classic = run(data, "anova", *BY, "--variances", "equal")
    assert classic["one_way"] == found(one_way_anova(groups))
    assert classic["pairs"] == found(compare_all_pairs(groups))
    contrast = contrast_by_day(ad, ce)
    (saved,) = run(data, "savings", *BY)["decisions"]
    savings = contrast.savings(0.95)
    assert (saved["savings_percent"], saved["p"]) == (savings.value, savings.p)
    assert saved["savings_percent_ci"] == pytest.approx(savings.ci, rel=0)
    for bounds, low, high, percent in (
        (("--low", "-3", "--high", "2.5"), -3.0, 2.5, False),
        (("--low", "-20", "--percent"), -20.0, None, True),
    ):
        (equal,) = run(data, "equivalence", *BY, *bounds)["decisions"]
        bounded = contrast.equivalence(low, high, percent=percent)
        expected = (low, high, bounded.value, bounded.p, bounded.equivalent)
        assert tuple(equal[key] for key in ("low", "high", "estimate", "p", "equivalent")) == expected
        says(str(equal["t_high"]), "reason" if high is None else str(bounded.t_high))


def test_text_is_one_sentence_with_one_p(data: Path) -> None:
    compared = compare_two(floats(AD), floats(CE), names=("AD", "CE"))
    assert good(labbook("stats", "compare", data, *BY, at=data.parent)).out == f"{compared.sentence(unit='J')}\n"
    of_days = (("compare",), ("compare", "--day", "date"), ("savings", "--day", "date"))
    for words in (*of_days, ("anova",), ("savings",), ("equivalence", "--low", "-3")):
        said = good(labbook("stats", words[0], data, *BY, *words[1:], at=data.parent)).out
        assert words not in of_days or len(re.findall(r"\bp [=<>]", said)) == 1
        assert not re.search(r"\b(nan|None|Undefined)\b", said)


def test_a_decimal_sign_that_could_be_one_of_thousands_is_asked_about(tmp_path: Path) -> None:
    path = table(tmp_path, {"CE": ("1,234", "1,250"), "AD": ("1,260", "1,311")}, ";")
    refused(labbook("stats", "compare", path, *BY, at=tmp_path), 2, "'1,234'", "could be a decimal or thousands")
    (compared,) = run(path, "compare", *BY, "--decimal", ",")["comparisons"]
    assert compared["mean_a"] == pytest.approx(1.2855, rel=1e-12)
    mixed = table(tmp_path, {"CE": ("980", "1.020"), "AD": ("1.010", "990")}, ";")
    refused(labbook("stats", "compare", mixed, *BY, "--decimal", ",", at=tmp_path), 2, "'1.020'", "without")
    (compared,) = run(mixed, "compare", *BY, "--decimal", ".")["comparisons"]
    assert compared["mean_a"] == pytest.approx(495.505, rel=1e-12)


def test_missing_values_are_refused_or_dropped_and_counted(tmp_path: Path) -> None:
    path = table(tmp_path, {"CE": (*CE[:4], ""), "AD": ("14.2", "NaN", "14.45", "n/a", "14.9")})
    said = "3 of 10 rows", "the first in line 6", "--missing drop"
    refused(labbook("stats", "compare", path, *BY, at=tmp_path), 2, *said)
    dropped = run(path, "compare", *BY, "--missing", "drop")
    (compared,) = dropped["comparisons"]
    assert (compared["n_a"], compared["n_b"], compared["missing"]) == (3, 4, 3)
    assert dropped["groups"] == {"CE": 4, "AD": 3}
    says(dropped["notes"], "3 of 10 rows", "lack")
    shown = good(labbook("stats", "compare", path, *BY, "--missing", "drop", at=tmp_path)).out
    says(shown.splitlines()[0], "3 missing")
    refused(labbook("stats", "compare", path, *BY, "--missing", "ignore", at=tmp_path), 2, "'ignore'")


CONSTANT = {"a": ["0.04"] * 10, "b": ["0.04"] * 30}


@pytest.mark.parametrize(
    "words",
    [("compare",), ("anova",), ("savings",), ("equivalence", "--low=-1", "--high=1"), ("compare", "--day=date")],
    ids=" ".join,
)
def test_constant_groups_have_no_p_and_say_why(words: Sequence[str], tmp_path: Path) -> None:
    """scipy and statsmodels make p = 4.6e-6 of these."""
    path = table(tmp_path, CONSTANT, days=("1", "2", "3") * 10)
    given = (words[0], path, "--value", "energy_J", "--by", "controller", *words[1:])
    shown = good(labbook("stats", *given, "--plot=plot.svg", at=tmp_path)).out
    assert re.search("scatter|differ by the same", shown)
    assert "no interval" in (tmp_path / "plot.svg").read_text(encoding="utf-8")
    data = good(labbook("stats", *given, "--json", at=tmp_path)).json
    assert not [name for name, value in flat(data) if re.search(r"(^|\.)p$", name) and value is not None]


def flat(data: Any, name: str = "") -> list[tuple[str, Any]]:
    """Every number of nested data with its path."""
    if isinstance(data, dict):
        return [pair for key, value in data.items() for pair in flat(value, f"{name}.{key}")]
    if isinstance(data, list):
        return [pair for value in data for pair in flat(value, name)] if any(isinstance(v, dict) for v in data) else []
    return [(name, data)]


def test_several_groups_are_a_family_and_can_be_one(tmp_path: Path) -> None:
    path = table(tmp_path, {"0": CE, "100": AD, "50": ("15.1", "15.3", "14.8", "15.9", "15.0")})
    words = ("--value", "energy_J", "--by", "controller")
    each = run(path, "compare", *words)
    assert [one["a"] for one in each["comparisons"]] == ["controller 50", "controller 100"]
    assert each["holm"]["names"] == ["controller 50", "controller 100"]
    assert min(each["holm"]["adjusted_p"]) == pytest.approx(2 * min(one["p"] for one in each["comparisons"]))
    pairs = run(path, "anova", *words)["pairs"]["pairs"]
    assert [one["b"] for one in pairs[:2]] == ["controller 50", "controller 100"]
    says(each["notes"][0], "first in order")
    (pooled,) = run(path, "compare", *words, "--pooled", "--control", "100")["comparisons"]
    assert (pooled["a"], pooled["n_a"]) == ("every other controller", 10)


@pytest.mark.parametrize(
    ("ending", "words"), [("png", ("compare",)), ("svg", ("anova",)), ("pdf", ("compare", "--day", "date"))]
)
def test_the_figure_is_written_in_every_form(ending: str, words: tuple[str, ...], data: Path) -> None:
    begins = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[ending]
    said = run(data, words[0], *BY, *words[1:], f"--plot=made.{ending}")
    assert said["files"] == {"plot": f"made.{ending}"}
    assert (data.parent / f"made.{ending}").read_bytes().startswith(begins)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("compare --value energyJ --by controller", "did you mean 'energy_J'?"),
        ("compare --value energy_J --by contoller", "did you mean 'controller'?"),
        ("compare --value energy_J --by controller --control CF", "did you mean 'CE'?"),
        ("compare --value energy_J", "data.csv has 'controller', 'energy_J', 'date'"),
        ("compare --value controller --by date", ", controller: 'CE'"),
        (f"compare {' '.join(BY)} --quantity apex", "--quantity is about a book"),
        (f"compare {' '.join(BY)} --alpha 5", "--alpha is 5.0: give a number between 0 and 1"),
        (f"compare {' '.join(BY)} --where controller=CE", "all values belong to one group (CE)"),
        (f"compare {' '.join(BY)} --where controller=XX", "there is no value to group by controller"),
        (f"compare {' '.join(BY)} --plot a", "--plot a does not say which form"),
        (f"compare {' '.join(BY)} --day dat", "did you mean 'date'?"),
        (f"anova {' '.join(BY)} --variances equl", "did you mean 'equal'?"),
        (f"equivalence {' '.join(BY)}", "add --low and --high"),
        (f"equivalence {' '.join(BY)} --low 3 --high 1", "give the lower one first"),
    ],
)
def test_refused_with_a_sentence(words: str, said: str, data: Path) -> None:
    command, *options = words.split()
    refused(labbook("stats", command, data, *options, at=data.parent), 2, said)


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        (["g,x", "a,1", "b,2,3"], ("line 3 of bad.csv", "3 cells")),
        (["g,x", "a,1", "b,inf"], ("line 3 of bad.csv, x", "'inf'")),
        (["g,x", "a,1,5", "b,2,5"], ("2 lines of bad.csv", "decimal comma")),
    ],
)
def test_a_table_that_cannot_be_read_is_refused(lines: list[str], said: tuple[str, ...], tmp_path: Path) -> None:
    written(tmp_path, lines, "bad.csv")
    refused(labbook("stats", "compare", "bad.csv", "--value", "x", "--by", "g", at=tmp_path), 2, *said)


@pytest.mark.parametrize("words", [("compare",), ("savings",), ("equivalence", "--low=-9", "--high=9")])
def test_groups_of_one_day_each_are_not_claimed_to_differ(words: tuple[str, ...], tmp_path: Path) -> None:
    lines = ["controller,energy_J,date", *(f"CE,{v},1" for v in CE), *(f"AD,{v},2" for v in AD)]
    path = written(tmp_path, lines)
    (decided,) = run(path, words[0], *BY, *words[1:], "--day", "date")["decisions"]
    assert decided["rule"] == "no claim"
    assert decided["p"] == {"reason": "no day holds both the control and the treatment"}
    lacking = written(tmp_path, ["controller,energy_J,date", "CE,1,1", "CE,2,1", "AD,1,", "AD,3,1"], "lacking.csv")
    refused(labbook("stats", words[0], lacking, *BY, *words[1:], "--day", "date", at=tmp_path), 2, "first in line 4")


def test_a_test_that_leaves_known_days_out_says_so(data: Path) -> None:
    for words in (("anova",), ("compare", "--route", "welch")):
        said = run(data, words[0], *BY, *words[1:], "--day", "date")["notes"]
        assert [note for note in said if "days" in note]
        assert not run(data, words[0], *BY, *words[1:])["notes"]


def test_rows_without_a_value_or_a_label_are_counted(tmp_path: Path) -> None:
    lines = ["v,g", "1,a", ",a", "1.5,a", "NA,a", "2,a", "3.5,a", "4,b", "5,b", "nan,b", "7,b", "8,"]
    path = written(tmp_path, lines)
    said = run(path, "compare", "--value", "v", "--by", "g", "--missing", "drop")
    says(said["notes"], "4 of 11 rows", "lack a value or a label")
    no_control = written(tmp_path, ["v,g", ",a", ",a", "1,b", "2,b"], "none.csv")
    empty = ("stats", "compare", no_control, "--value=v", "--by=g", "--control=a", "--missing=drop")
    assert "group a is empty" in good(labbook(*empty, at=tmp_path)).out


def test_only_rows_that_are_kept_must_hold_numbers(tmp_path: Path) -> None:
    path = written(tmp_path, ["g,x,use", "a,1,yes", "a,1.2,yes", "b,2,yes", "b,2.5,yes", 'b,"1,2 (broken)",no'])
    words = ("compare", "--value", "x", "--by", "g")
    assert run(path, *words, "--where", "use=yes")["groups"] == {"a": 2, "b": 2}
    said = "line 6 of data.csv, x: '1,2 (broken)'"
    refused(labbook("stats", *words[:1], path, *words[1:], at=tmp_path), 2, said)
    refused(labbook("stats", *words[:1], path, *words[1:], "--where", "use in (yes, no)", at=tmp_path), 2, said)


def test_conditions_read_numbers_as_the_table_writes_them(tmp_path: Path) -> None:
    path = written(tmp_path, ["g;x;gain", "a;1;0,5", "a;1,2;9,5", "b;2;10,5", "b;2,5;10,5", "b;3;NaN"])
    words = ("compare", "--value", "x", "--by", "g")
    assert run(path, *words, "--where", "gain > 9.4")["groups"] == {"a": 1, "b": 2}
    written(tmp_path, ["g,x,gain", "a,1,9", "a,2,10", "b,2,oops"])
    refused(labbook("stats", *words[:1], path, *words[1:], "--where", "gain<10", at=tmp_path), 2, "'gain'", "no order")


def test_what_spreadsheets_add_is_no_hindrance(tmp_path: Path) -> None:
    rows = ["g;x;;", "a;1,5;;", "a;1,7;;", "b;2;;", "b;2,5;;"]
    plain = run(written(tmp_path, rows), "compare", "--value", "x", "--by", "g")
    assert run(written(tmp_path, ["\ufeffsep=;", *rows]), "compare", "--value", "x", "--by", "g") == plain
    path = written(tmp_path, ["sep=;", *rows[:2], "a;oops;;"])
    told = "line 4 of data.csv, x: 'oops'"
    refused(labbook("stats", "compare", path, "--value=x", "--by=g", at=tmp_path), 2, told)


WORKED = {
    "CE": {1: "42.1 40.3", 2: "44.0 41.6 43.1", 3: "40.2", 4: "43.3 45.2"},
    "AD": {1: "37.9 36.2 38.8", 2: "38.4 39.9", 3: "36.9 35.1 37.7", 4: "39.8 38.5 40.6 39.1"},
}


@pytest.mark.parametrize(
    ("where", "rule", "p"),
    [
        ("date>0", "paired on day means", 7.663569044e-4),
        ("date<4", "within days", 1.400491989e-2),
        ("date=1 and controller=AD or date=2 and controller=CE", "no claim", None),
    ],
)
def test_where_days_are_known_the_answer_is_by_shared_days(
    where: str, rule: str, p: float | None, tmp_path: Path
) -> None:
    days_of = [(name, day, values.split()) for name, days in WORKED.items() for day, values in days.items()]
    rows = [f"{name},{value},{day}" for name, day, values in days_of for value in values]
    path = written(tmp_path, ["controller,energy_J,date", *rows])
    words = ("compare", *BY, "--day", "date", "--where", where)
    answer = run(path, *words)
    assert "comparisons" not in answer
    (decided,) = answer["decisions"]
    assert decided["rule"] == rule
    if p is not None:
        assert decided["p"] == pytest.approx(p, rel=1e-9)
    says(good(labbook("stats", words[0], path, *words[1:], at=tmp_path)).out, "shared days", rule)
    (saved,) = run(path, "savings", *words[1:])["decisions"]
    assert (saved["rule"], saved["p"]) == (rule, decided["p"])


@pytest.mark.parametrize("asked", [lambda it: compare(it, None), lambda it: equal(it, (-9, 9, False))])
def test_where_days_decide_their_intervals_are_drawn(asked: Callable[[Question], Answer]) -> None:
    values = {"a": (1.0, 2.0, 4.0, 3.0), "b": (2.0, 4.0, 5.0, 6.0), "c": (3.0, 5.0, 9.0, 7.0)}
    rows = [(label, place, value) for label, column in values.items() for place, value in enumerate(column)]
    days = tuple(Observation(value, label, f"2021-06-1{place}") for label, place, value in rows)
    none = tuple(Observation(value, label) for label, _place, value in rows)
    for cells, by_days in ((days, True), (none, False)):
        observed = Observations("data.csv", "energy", "J", "g", "a", cells)
        found = asked(Question(observed, "refuse", 0.05))
        drawn = found.drawn()
        assert ("by shared days" in drawn.interval) is by_days
        key = "decisions" if "decisions" in found.data else "comparisons"
        for one, number in zip(found.data[key], drawn.differences[1:], strict=True):
            assert number is not None
            ends = next(one[name] for name in ("difference_ci", "estimate_ci") if name in one)
            assert [number.ci_low, number.ci_high] == [*ends]
