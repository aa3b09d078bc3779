"""W1 to W27: inputs on which programs in wide use are wrong, each with the truth and the wrong answer by name.

The cases are those of `benchmarks/stats_evidence/weaknesses`, from which `docs/statistics/weaknesses.csv` is written;
other programs are asked there only, so that nothing here fails when one of them mends its fault.
"""

import functools
import math
import warnings

import mpmath
import pytest

from benchmarks.stats_evidence.document import read
from benchmarks.stats_evidence.weaknesses import tails
from benchmarks.stats_evidence.weaknesses.answers import RIGHT_TO, Verdict, alike, ours, theirs, verdict
from benchmarks.stats_evidence.weaknesses.case import NoNumber, Number, Peer, Question, Weakness
from benchmarks.stats_evidence.weaknesses.registry import WEAKNESSES
from benchmarks.stats_evidence.weaknesses.rows import rows
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from tests.helpers.exact_tests import dunnett_tail, moments, mpf

of_today = functools.cache(ours)
"""What labbook answers to each question, asked once for the truth and for the table."""


def test_all_cases_are_there_and_each_names_a_wrong_answer():
    assert list(WEAKNESSES) == [f"W{number}" for number in range(1, 28)]
    for case in WEAKNESSES.values():
        assert any(question.others for question in case.questions), case.name


def test_the_table_shows_labbooks_answers_of_today():
    """The truth and the other programs beside them are from when it was last written."""
    now = {
        (case.name, question.what): of_today(question.ours).text(question.digits)
        for case in WEAKNESSES.values()
        for question in case.questions
    }
    written = [row for row in read("weaknesses") if row["program"] == "labbook"]
    assert {(row["case"], row["question"]): row["answer"] for row in written} == now


@pytest.mark.parametrize("name", WEAKNESSES)
def test_labbook_is_right_where_others_are_not(name):
    for question in WEAKNESSES[name].questions:
        found, truth = of_today(question.ours), question.truth
        if isinstance(truth, NoNumber):
            assert found.number is None, question.what
            assert truth.cause in found.words, question.what
        else:
            assert found.number is not None, f"{question.what}: {found.words}"
            assert alike(found.number, truth.value(), truth.rel), question.what
        for peer in question.others:
            if isinstance(peer.recorded, str):
                assert peer.recorded != found.text(3), peer.call
            else:
                assert found.number is None or not alike(found.number, peer.recorded, RIGHT_TO), peer.call


def raising(error):
    def answer():
        raise error

    return answer


def warning():
    warnings.warn("precision loss", RuntimeWarning, stacklevel=2)
    return 0.5


HALF = Number(lambda: 0.25, "definition")
NONE = NoNumber("no scatter")


@pytest.mark.parametrize(
    ("answer", "recorded", "truth", "expected"),
    [
        (lambda: 0.501, 0.5, HALF, Verdict.AS_RECORDED),
        (lambda: 0.7, 0.5, HALF, Verdict.OTHERWISE_WRONG),
        (lambda: 0.25 + 1e-9, 0.5, HALF, Verdict.MENDED),
        (lambda: 0.25 + 1e-9, 0.2500003, HALF, Verdict.MENDED),
        (lambda: math.nan, "nan", HALF, Verdict.AS_RECORDED),
        (lambda: math.nan, 0.5, HALF, Verdict.OTHERWISE_WRONG),
        (lambda: -math.inf, -math.inf, HALF, Verdict.AS_RECORDED),
        (lambda: -3.0, -math.inf, HALF, Verdict.OTHERWISE_WRONG),
        (raising(ZeroDivisionError()), "ZeroDivisionError", HALF, Verdict.AS_RECORDED),
        (raising(ValueError()), "ZeroDivisionError", HALF, Verdict.OTHERWISE_WRONG),
        (lambda: 0.51, 0.5, NONE, Verdict.AS_RECORDED),
        (lambda: 0.7, 0.5, NONE, Verdict.OTHERWISE_WRONG),
        (lambda: math.nan, 0.5, NONE, Verdict.MENDED),
        (raising(ValueError()), 0.5, NONE, Verdict.MENDED),
        (raising(ValueError()), "ValueError", NONE, Verdict.AS_RECORDED),
        (raising(ModuleNotFoundError()), 0.5, HALF, Verdict.NOT_INSTALLED),
    ],
)
def test_an_answer_of_today_is_set_beside_the_truth_and_the_recorded_one(answer, recorded, truth, expected):
    peer = Peer("numpy", "f", answer, recorded)
    assert verdict(peer, theirs(peer), truth) is expected


def test_a_program_that_cannot_be_asked_so_is_no_wrong_answer():
    """A function that is gone, or takes other arguments, must not be told as an error of its numbers."""
    with pytest.raises(TypeError):
        theirs(Peer("numpy", "f", lambda: math.sqrt(1.0, 2.0), 0.5))


def test_rows_name_versions_faults_and_what_is_no_longer_so():
    others = (
        Peer("scipy", "silently", lambda: 0.5, 0.5),
        Peer("numpy", "loudly", warning, 0.5),
        Peer("statsmodels", "mended", lambda: 0.25, 0.75),
        Peer("pingouin", "absent", raising(ModuleNotFoundError()), 0.125),
    )
    questions = (
        Question("p", HALF, lambda: 0.25, others),
        Question("t", NONE, lambda: Undefined(Reason.AS_SAID, said="no scatter"), ()),
    )
    of_p, of_t = [], []
    for row in rows([Weakness("W1", "halves", "1 and 2", questions)]):
        assert (row["case"], row["title"], row["values"]) == ("W1", "halves", "1 and 2")
        answer = (row["program"].split()[0], row["call"], row["answer"], row["standing"], row["silent"])
        (of_p if row["question"] == "p" else of_t).append((row["truth"], row["known_from"], *answer))
        assert row["program"].startswith("scipy 1.") or row["call"] != "silently"
    assert of_p == [
        ("0.25", "definition", "labbook", "", "0.25", "right", ""),
        ("0.25", "definition", "scipy", "silently", "0.5", "wrong", "yes"),
        ("0.25", "definition", "numpy", "loudly", "0.5", "wrong", "no"),
        ("0.25", "definition", "statsmodels", "mended", "0.25", "right now", ""),
        ("0.25", "definition", "pingouin", "absent", "0.125", "not installed, as recorded", ""),
    ]
    assert of_t == [("no such number", "", "labbook", "", "no scatter", "right", "")]


@pytest.mark.soak
def test_the_truth_of_dunnetts_p_is_that_of_25_digits():
    """20 s of mpmath: too long for every run."""
    groups = [moments(values) for values in (tails.CONTROL, *tails.TREATED.values())]
    df = sum(n - 1 for n, _, _ in groups)
    pooled = sum(squares for _, _, squares in groups) / df
    (n_control, mean_control, _), (n, mean, _) = groups[0], groups[2]
    with mpmath.workdps(25):
        t = abs(mpf(mean - mean_control)) / mpmath.sqrt(mpf(pooled * (n + n_control) / (n * n_control)))
        found = dunnett_tail(t, n_control, [size for size, _, _ in groups[1:]], df, 0.25)
    assert float(found) == pytest.approx(tails.DUNNETT_P, rel=1e-15)
