import importlib
import pkgutil
import subprocess
import sys

import pytest

import stats

MODULES = [module.name for module in pkgutil.iter_modules(stats.__path__, "stats.")]


@pytest.mark.parametrize("name", MODULES)
def test_every_public_name_is_documented(name: str) -> None:
    module = importlib.import_module(name)
    assert module.__doc__
    public = [value for word, value in vars(module).items() if not word.startswith("_") and callable(value)]
    for value in public:
        if getattr(value, "__module__", None) == name:
            assert value.__doc__, value


def test_statistics_load_without_database_tables_or_plots() -> None:
    heavy = ("sqlalchemy", "pandas", "matplotlib", "pint", "statsmodels", "scipy.stats")
    code = f"import sys, {', '.join(MODULES)}; print([name for name in {heavy!r} if name in sys.modules])"
    printed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert printed.stdout.strip() == "[]"
