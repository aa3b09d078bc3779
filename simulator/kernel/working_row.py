"""The kernel's working row as compiled code sees it: one address, of which numbers are read and written by place.

numba hands an array on as seven words, counts the references to it, and looks whether each place is negative. A kernel
needs nothing of that: its row is made once, in `make_batch`, and outlives every call. Functions of the kernel compile
for an address or for an array, so that they can be called with the latter where time does not count.
"""

from __future__ import annotations

import struct
from typing import Any

from llvmlite import ir
from numba import types
from numba.core.imputils import lower_builtin
from numba.extending import type_callable

from simulator.compiled import Row

_pointer_to: Any = types.CPointer
_ADDRESS = _pointer_to(types.float64)
_lower: Any = lower_builtin
_type: Any = type_callable


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


_FIFTH, _OF_ONE = 0x33333333, 0x4CB8A000
"""2^32 / 5, and 6/5 of the upper half of 1's bits, less what makes the largest error smallest."""


def per_fifth_root_guess(x: float) -> float:
    """Return x^(-1/5) of a positive number to 4 %: its bits are nearly its logarithm."""
    upper = struct.unpack("<Q", struct.pack("<d", x))[0] >> 32
    guess: float = struct.unpack("<d", struct.pack("<Q", _OF_ONE - (upper * _FIFTH >> 32) << 32))[0]
    return guess


def guess_per_fifth_root(builder: Any, value: Any) -> Any:
    """Compile that of a number, or of a number of each lane."""
    lanes = getattr(value.type, "count", 0)
    bits = ir.VectorType(ir.IntType(64), lanes) if lanes else ir.IntType(64)

    def each(number: int) -> Any:
        return ir.Constant(bits, [number] * lanes if lanes else number)

    upper = builder.lshr(builder.bitcast(value, bits), each(32))
    fifth = builder.lshr(builder.mul(upper, each(_FIFTH)), each(32))
    return builder.bitcast(builder.shl(builder.sub(each(_OF_ONE), fifth), each(32)), value.type)


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


_type(choose)(_type_of_choice)
_lower(choose, types.Boolean, types.Float, types.Float)(_choose)
_type(per_fifth_root_guess)(lambda context: lambda x: types.float64 if x == types.float64 else None)
_lower(per_fifth_root_guess, types.Float)(lambda context, builder, sign, value: guess_per_fifth_root(builder, *value))
_type(lanes_in)(_type_of_lanes_in)
_lower(lanes_in, types.Boolean)(_lanes_in)
_type(address_of)(_type_of_address)
_lower(address_of, types.Array)(_take_address)
