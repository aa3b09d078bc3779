import subprocess
import sys

import stats


def test_public_names_are_listed_sorted_and_documented():
    constants = [name for name in stats.__all__ if name.isupper()]
    classes = [name for name in stats.__all__ if name[0].isupper() and not name.isupper()]
    functions = [name for name in stats.__all__ if name[0].islower()]
    assert stats.__all__ == sorted(constants) + sorted(classes) + sorted(functions)
    for name in classes + functions:
        assert getattr(stats, name).__doc__, name


def test_statistics_load_without_database_tables_or_plots():
    heavy = ("sqlalchemy", "pandas", "matplotlib", "pint", "statsmodels", "scipy.stats")
    code = f"import sys, stats; print([name for name in {heavy!r} if name in sys.modules])"
    printed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert printed.stdout.strip() == "[]"
