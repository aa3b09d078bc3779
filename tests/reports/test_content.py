import dataclasses
import subprocess
import sys

from data_schema.outcomes import Outcome


def test_a_condition_finds_its_levels_and_summaries(content):
    condition = content.conditions[0]
    assert condition.level("foot").label == "small"
    assert condition.level("weather") is None
    assert condition.summary(Outcome.APEX) is condition.summaries[Outcome.APEX]
    assert dataclasses.replace(condition, summaries={}).summary(Outcome.APEX) is None


def test_a_report_is_written_without_a_database():
    """In an interpreter of its own: no sqlalchemy, no statistics, no reader comes along."""
    program = (
        "import sys, reports.page.writing, reports.figures.log\n"
        "loaded = {name.split('.')[0] for name in sys.modules}\n"
        "print(sorted(loaded & {'sqlalchemy', 'stats', 'ingest', 'simulator', 'labbook'}))\n"
        "print([name for name in sys.modules if name == 'matplotlib.pyplot'])\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.split("\n")[:2] == ["[]", "[]"]
