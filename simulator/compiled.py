"""The three ways in which functions of the simulator are compiled, typed as what they are.

numba is loaded by the first function that is compiled: a report whose predictions are all stored reads scenes and
effects, and needs none of it.

With NUMBA_DISABLE_JIT=1 all leave the function as it stands. Divisions are IEEE divisions (no checks in the
inner loops), the rounding of every operation is kept (no fastmath: results repeat bit for bit), and other threads
run meanwhile.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Row = NDArray[np.float64]
"""An array of numbers."""
Function = Callable[..., Any]
"""A function of numbers and arrays that numba can compile."""
F = TypeVar("F", bound=Function)
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

    _leave_inner_code_to_callers()
    njit: Any = numba.njit  # its types know neither of the options that leave wrappers out
    return njit(**options)


@functools.cache
def _leave_inner_code_to_callers() -> None:
    """Let numba optimise what Python calls, and make machine code of it, not of each function within it as well.

    An inner function is in those that call it, whole. A kernel compiles in two thirds of the time, to the same bits.
    """
    from numba.core import codegen
    from numba.core.registry import cpu_target

    base: Any = codegen.JITCodeLibrary

    class Library(base):  # type: ignore[misc]
        """Functions that become machine code when the address of one is asked for."""

        _is_made = False

        def _optimize_final_module(self) -> None:
            """Wait for the one that asks."""

        def _finalize_final_module(self) -> None:
            if getattr(self, "_compiled_object", None) is not None:  # it comes from disk
                self._is_made = True
                super()._finalize_final_module()
                return
            self._finalize_dynamic_globals()
            self._verify_declare_only_symbols()
            self._finalized = True

        def get_pointer_to_function(self, name: str) -> Any:
            self._ensure_finalized()
            if not self._is_made and any(function.name == name for function in self.get_defined_functions()):
                self._is_made = True
                super()._optimize_final_module()
                super()._finalize_final_module()
            return super().get_pointer_to_function(name)

    made: Any = cpu_target.target_context.codegen()
    set_env = made.set_env

    def set_env_where_it_is(name: str, env: Any) -> None:
        if made._engine.get_global_value_address(name):  # none without machine code
            set_env(name, env)

    made._library_class = Library
    made.set_env = set_env_where_it_is
