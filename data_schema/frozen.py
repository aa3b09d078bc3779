"""How a class of values is made: a frozen dataclass with slots."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import Field, dataclass, field
from typing import Any, TypeVar, dataclass_transform, overload

T = TypeVar("T")


@overload
@dataclass_transform(frozen_default=True, field_specifiers=(Field, field))
def frozen(cls: type[T], /) -> type[T]: ...


@overload
def frozen(*, eq: bool = True, kw_only: bool = False) -> Callable[[type[T]], type[T]]: ...


def frozen(cls: type[Any] | None = None, /, *, eq: bool = True, kw_only: bool = False) -> Any:
    """Make a class a dataclass whose fields are set once and which has no others; `eq`, `kw_only` as dataclasses have.

    >>> @frozen
    ... class Point:
    ...     x: float
    >>> Point(1.0)
    Point(x=1.0)
    """

    def made(of: type[Any]) -> type[Any]:
        return dataclass(frozen=True, slots=True, eq=eq, kw_only=kw_only)(of)

    return made if cls is None else made(cls)
