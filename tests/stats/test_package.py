"""The package under one import: what users call is there by name, and is loaded when it is asked for."""

import importlib
import subprocess
import sys

import pytest

import stats


def test_what_users_call_is_there_by_name() -> None:
    """Whatever was imported before, also where a function is called as its module is."""
    assert set(stats.__all__) == set(stats._MODULE_OF)
    assert set(stats.__all__) <= set(dir(stats))
    for name in stats.__all__:
        module = importlib.import_module(f"stats.{stats._MODULE_OF[name]}")
        assert getattr(stats, name) is getattr(module, name)
        assert getattr(stats, name).__module__ == module.__name__
    with pytest.raises(AttributeError, match="no attribute 'compare_tow'"):
        _ = stats.compare_tow


def test_a_notebook_needs_one_import() -> None:
    """Loading the package loads nothing of weight."""
    code = (
        "import sys, stats; light = not {'numpy', 'scipy', 'pandas'} & set(sys.modules); a, b = [1, 2, 4], [2, 3, 3]; "
        "print(light, stats.compare_two(a, b).n_a, stats.one_way_anova([a, b]).df_between)"
    )
    printed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert printed.stdout.split()[:3] == ["True", "3", "1"]
