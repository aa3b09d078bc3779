"""The three ways in which functions of the simulator are compiled, typed as what they are.

numba is loaded by the first function that is compiled: a report whose predictions are all stored reads scenes and
effects, and needs none of it.

With NUMBA_DISABLE_JIT=1 all leave the function as it stands. Divisions are IEEE divisions (no checks in the
inner loops), the rounding of every operation is kept (no fastmath: results repeat bit for bit), and other threads
run meanwhile.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])
_OPTIONS: dict[str, Any] = {"error_model": "numpy", "nogil": True}


def compiled(function: F) -> F:
    """Compile a function that Python calls."""
    result: F = _njit(**_OPTIONS)(function)
    return result


def inner(function: F) -> F:
    """Compile a function that only compiled functions call: it needs no entry from Python, which halves its time."""
    result: F = _njit(no_cpython_wrapper=True, no_cfunc_wrapper=True, **_OPTIONS)(function)
    return result


def inlined(function: F) -> F:
    """Compile an inner function anew at every call, where it then finds in registers what the caller has just computed.

    It makes the caller longer: for what a step calls again and again.
    """
    result: F = _njit(no_cpython_wrapper=True, no_cfunc_wrapper=True, forceinline=True, **_OPTIONS)(function)
    return result


def _njit(**options: Any) -> Any:
    import numba

    njit: Any = numba.njit  # its types know neither of the options that leave wrappers out
    return njit(**options)
