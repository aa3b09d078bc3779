"""The kernel's working row as compiled code sees it: one address, of which numbers are read and written by place.

numba hands an array on as seven words, counts the references to it, and looks whether each place is negative. A kernel
needs nothing of that: its row is made once, in `make_batch`, and outlives every call. Functions of the kernel compile
for an address or for an array, so that they can be called with the latter where time does not count.
"""

from __future__ import annotations

import operator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import type_callable

from simulator.compiled import Row

_pointer_to: Any = types.CPointer
_ADDRESS = _pointer_to(types.float64)
_sign: Any = signature
_lower: Any = lower_builtin
_type: Any = type_callable
_infer: Any = infer_global


def address_of(row: Row) -> Row:
    """Return the address of an array's numbers where this is compiled, and otherwise the array.

    The array must outlive what is done with its address.
    """
    return row


def choose(which: bool, first: float, second: float) -> float:
    """Return the first number where a condition holds and else the second, without a branch where this is compiled."""
    return first if which else second


def lanes_in(which: bool) -> int:
    """Return a whole number, whose bit i says whether a condition holds in lane i: 0 where it holds in none."""
    return 1 if which else 0


def _type_of_lanes_in(context: Any) -> Any:
    return lambda which: types.int64 if which == types.boolean else None


def _lanes_in(context: Any, builder: Any, sign: Any, arguments: Any) -> Any:
    return builder.zext(arguments[0], ir.IntType(64))


def _type_of_choice(context: Any) -> Any:
    return lambda which, first, second: types.float64 if which == types.boolean else None


def _choose(context: Any, builder: Any, sign: Any, arguments: Any) -> Any:
    return builder.select(*arguments)


def _type_of_address(context: Any) -> Any:
    return lambda row: _ADDRESS if isinstance(row, types.Array) else None


def _take_address(context: Any, builder: Any, sign: Any, arguments: Any) -> Any:
    return context.make_array(sign.args[0])(context, builder, arguments[0]).data


def _type_of_reading(self: Any, arguments: Any, keywords: Any) -> Any:
    row, place = arguments
    fits = row == _ADDRESS and isinstance(place, types.Integer)
    return _sign(types.float64, row, types.intp) if fits else None


def _read(context: Any, builder: Any, sign: Any, arguments: Any) -> Any:
    row, place = arguments
    return builder.load(builder.gep(row, [place]))


def _type_of_writing(self: Any, arguments: Any, keywords: Any) -> Any:
    row, place, _ = arguments
    fits = row == _ADDRESS and isinstance(place, types.Integer)
    return _sign(types.none, row, types.intp, types.float64) if fits else None


def _write(context: Any, builder: Any, sign: Any, arguments: Any) -> Any:
    row, place, value = arguments
    builder.store(value, builder.gep(row, [place]))
    return context.get_dummy_value()


_type(choose)(_type_of_choice)
_lower(choose, types.Boolean, types.Float, types.Float)(_choose)
_type(lanes_in)(_type_of_lanes_in)
_lower(lanes_in, types.Boolean)(_lanes_in)
_type(address_of)(_type_of_address)
_lower(address_of, types.Array)(_take_address)
for _operation, _generic, _arguments, _generate in (
    (operator.getitem, _type_of_reading, (types.intp,), _read),
    (operator.setitem, _type_of_writing, (types.intp, types.float64), _write),
):
    _infer(_operation)(type(_generic.__name__, (AbstractTemplate,), {"generic": _generic}))
    _lower(_operation, _ADDRESS, *_arguments)(_generate)
