"""What the methods of a report name, and what they cite."""

from __future__ import annotations

import pytest

from reports.content import Source
from tests.labbook.conftest import CONFOUNDED, Reports

NAMES = {
    Source.FIELLER: "Fieller",
    Source.HOLM: "Holm",
    Source.PAIRED_ON_DAY_MEANS: "paired t on day means",
    Source.TOST: "TOST",
}


@pytest.mark.parametrize(
    ("analysis", "where"),
    [("", None), ("apex_bounds_percent = [-3, 3]", None), pytest.param("", CONFOUNDED, marks=pytest.mark.soak)],
)
def test_what_the_methods_name_is_cited_and_nothing_else(reports: Reports, analysis: str, where: str | None) -> None:
    content = reports(analysis, where).content
    text = " ".join(content.methods)
    of_thesis = (Source.THESIS, Source.WELCH)  # the tests that stand beside
    assert [one for one in content.sources if one not in of_thesis] == [
        one for one, name in NAMES.items() if name in text
    ]
    tested = any(isinstance(one.over_runs.t.value, float) for one in content.comparisons)
    assert (Source.THESIS in content.sources) is tested
