import pytest

from data_schema.vocabulary import Undefined
from labbook.presenting.numbers import ShownNumbers
from stats.compare.savings import percent_savings
from stats.compare.two_sample import compare_two

SHOWN = ShownNumbers().of_sides(("the treatment", "the control"), "run")


@pytest.mark.parametrize(("side", "control", "treated"), [("control", [], [1.0, 2.0]), ("treatment", [1.0, 2.0], [])])
def test_an_empty_side_is_called_as_the_report_calls_it(side: str, control: list[float], treated: list[float]) -> None:
    """A comparison has the treatment first, savings have the control first."""
    for none in (compare_two(treated, control).difference, percent_savings(control, treated).percent):
        assert isinstance(none, Undefined)
        assert f"the {side} is empty" in SHOWN.reword(none).reason
