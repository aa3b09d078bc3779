import subprocess
import sys


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
