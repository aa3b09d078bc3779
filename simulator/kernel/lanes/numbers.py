"""Numbers of several lanes side by side, in one vector register, as compiled code sees them.

Arithmetic, comparisons, `min`, `max`, `abs` and functions are done lane by lane, each rounded as a single number is: a
lane's bits depend neither on its neighbours nor on how many there are. A comparison gives a mask, by which
`simulator.kernel.working_row.choose` selects. Functions of the kernel that take no branch by a number compile for lanes
as for single numbers.
"""

from __future__ import annotations

import math
import operator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.datamodel import models
from numba.core.datamodel.registry import register_default
from numba.core.imputils import lower_builtin, lower_cast
from numba.core.typeconv.castgraph import Conversion
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic

from simulator.kernel.working_row import choose, guess_per_fifth_root, lanes_in, per_fifth_root_guess

_infer: Any = infer_global
_lower: Any = lower_builtin
_cast: Any = lower_cast
_sign: Any = signature
_intrinsic: Any = intrinsic
_Template: Any = AbstractTemplate
_pointer_to: Any = types.CPointer
_model_of: Any = models.PrimitiveModel
_function_in: Any = cgutils.get_or_insert_function
_BYTES = 8


class Lanes(types.Type):
    """A number of each of `width` lanes."""

    def __init__(self, width: int) -> None:
        self.width = width
        super().__init__(name=f"Lanes({width})")

    def unify(self, typing_context: Any, other: Any) -> Any:
        """A number beside one of each lane is that of all."""
        return self if isinstance(other, types.Number) else None

    def can_convert_from(self, typing_context: Any, other: Any) -> Any:
        """A number becomes that of all lanes."""
        return Conversion.safe if isinstance(other, types.Number) else None


class Which(types.Type):
    """Whether something holds, for each of `width` lanes."""

    def __init__(self, width: int) -> None:
        self.width = width
        super().__init__(name=f"Which({width})")


def _model(element: Any) -> Any:
    def make(manager: Any, of: Any) -> Any:
        return _model_of(manager, of, ir.VectorType(element, of.width))

    return make


register_default(Lanes)(_model(ir.DoubleType()))
register_default(Which)(_model(ir.IntType(1)))


def _width_of(kind: Any, arguments: Any) -> int | None:
    widths = {each.width for each in arguments if isinstance(each, kind)}
    beside = kind | types.Number if kind is Lanes else kind
    return widths.pop() if len(widths) == 1 and all(isinstance(each, beside) for each in arguments) else None


def _define(operation: Any, kind: Any, count: int, generate: Any, result: Any) -> None:
    """Let an operation take so many of a kind, lanes also with numbers beside them."""

    def generic(self: Any, arguments: Any, keywords: Any) -> Any:
        width = _width_of(kind, arguments) if len(arguments) == count else None
        return None if width is None else _sign(result(width), *[kind(width)] * count)

    _infer(operation)(type("generic", (_Template,), {"generic": generic}))
    _lower(operation, *[kind] * count)(lambda context, builder, sign, arguments: generate(builder, *arguments))


def _of_lanes(operation: Any, count: int, generate: Any, result: Any = Lanes) -> None:
    _define(operation, Lanes, count, generate, result)


def _call(name: str) -> Any:
    def generate(builder: Any, value: Any) -> Any:
        kind = ir.FunctionType(value.type, [value.type])
        whole = f"llvm.{name}.v{value.type.count}f64"
        return builder.call(_function_in(builder.module, kind, whole), [value])

    return generate


def _larger(builder: Any, first: Any, second: Any) -> Any:
    return builder.select(builder.fcmp_ordered(">", second, first), second, first)


def _smaller(builder: Any, first: Any, second: Any) -> Any:
    return builder.select(builder.fcmp_ordered("<", second, first), second, first)


for _name, *_operations in (
    ("fadd", operator.add, operator.iadd),
    ("fsub", operator.sub, operator.isub),
    ("fmul", operator.mul, operator.imul),
    ("fdiv", operator.truediv, operator.itruediv),
):
    for _operation in _operations:
        _of_lanes(_operation, 2, lambda builder, a, b, _name=_name: getattr(builder, _name)(a, b))
for _name, _operation in (
    ("<", operator.lt),
    ("<=", operator.le),
    (">", operator.gt),
    (">=", operator.ge),
    ("==", operator.eq),
):
    _of_lanes(_operation, 2, lambda builder, a, b, _name=_name: builder.fcmp_ordered(_name, a, b), Which)
_of_lanes(operator.ne, 2, lambda builder, a, b: builder.fcmp_unordered("!=", a, b), Which)
_of_lanes(operator.neg, 1, lambda builder, a: builder.fneg(a))
_of_lanes(abs, 1, _call("fabs"))
for _function in (math.sqrt, math.exp, math.log, math.sin, math.cos, math.floor):
    _of_lanes(_function, 1, _call(_function.__name__))
_of_lanes(per_fifth_root_guess, 1, guess_per_fifth_root)
for _most, _pick in ((max, _larger), (min, _smaller)):
    _of_lanes(_most, 2, _pick)
    _of_lanes(_most, 3, lambda builder, a, b, c, _pick=_pick: _pick(builder, _pick(builder, a, b), c))
for _operation, _name in (
    (operator.and_, "and_"),
    (operator.iand, "and_"),
    (operator.or_, "or_"),
    (operator.ior, "or_"),
):
    _define(_operation, Which, 2, lambda builder, a, b, _name=_name: getattr(builder, _name)(a, b), Which)
_define(operator.invert, Which, 1, lambda builder, a: builder.not_(a), Which)


def _spread(builder: Any, value: Any, width: int) -> Any:
    vector = ir.VectorType(value.type, width)
    one = builder.insert_element(ir.Constant(vector, ir.Undefined), value, ir.IntType(32)(0))
    order = ir.Constant(ir.VectorType(ir.IntType(32), width), [0] * width)
    return builder.shuffle_vector(one, ir.Constant(vector, ir.Undefined), order)


def _from_number(context: Any, builder: Any, kind: Any, to: Any, value: Any) -> Any:
    return _spread(builder, context.cast(builder, value, kind, types.float64), to.width)


_cast(types.Number, Lanes)(_from_number)


def _type_of_choice(self: Any, arguments: Any, keywords: Any) -> Any:
    which, *both = arguments
    fits = isinstance(which, Which) and all(isinstance(each, Lanes | types.Number) for each in both)
    return _sign(Lanes(which.width), which, *[Lanes(which.width)] * 2) if fits else None


def _choose(context: Any, builder: Any, sign: Any, arguments: Any) -> Any:
    return builder.select(*arguments)


_infer(choose)(type("choice", (_Template,), {"generic": _type_of_choice}))
_lower(choose, Which, Lanes, Lanes)(_choose)


def _lanes_in(builder: Any, which: Any) -> Any:
    return builder.zext(builder.bitcast(which, ir.IntType(which.type.count)), ir.IntType(64))


_define(lanes_in, Which, 1, _lanes_in, lambda _width: types.int64)


def make_lanes_of(width: int) -> Any:
    """Compose `(block)`: the address of an array, shape (places, width), as a working row of lanes.

    The array must outlive what is done with its address.
    """
    address: Any = _pointer_to(Lanes(width))

    @_intrinsic  # type: ignore[untyped-decorator]
    def lanes_of(typing_context: Any, block: Any) -> Any:
        def generate(context: Any, builder: Any, sign: Any, arguments: Any) -> Any:
            data = context.make_array(sign.args[0])(context, builder, arguments[0]).data
            return builder.bitcast(data, context.get_value_type(address))

        return _sign(address, block), generate

    return lanes_of


def _read(context: Any, builder: Any, sign: Any, arguments: Any) -> Any:
    row, place = arguments
    return builder.load(builder.gep(row, [place]), align=_BYTES)


def _write(context: Any, builder: Any, sign: Any, arguments: Any) -> Any:
    row, place, value = arguments
    builder.store(value, builder.gep(row, [place]), align=_BYTES)
    return context.get_dummy_value()


_lower(operator.getitem, types.CPointer, types.Integer)(_read)
_lower(operator.setitem, types.CPointer, types.Integer, Lanes)(_write)
