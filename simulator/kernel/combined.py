"""Functions of the same arguments that are combined to one: what effects add to each other's rates, forces and sums."""

from __future__ import annotations

from collections.abc import Iterable
from functools import reduce

from simulator.compiled import Function, inlined

nothing: Function = inlined(lambda *arguments: None)
"""A function that does nothing, of any arguments."""


def in_turn(functions: Iterable[Function]) -> Function:
    """Compose a function that calls these one after the other; one that does nothing where there are none."""
    return reduce(_then, functions, nothing)


def summed(functions: Iterable[Function]) -> Function:
    """Compose a function that adds up what these return, from the first on."""
    return reduce(_plus, functions)


def largest(functions: Iterable[Function]) -> Function:
    """Compose a function that returns the largest number that these do."""
    return reduce(_or_more, functions)


def _then(first: Function, second: Function) -> Function:
    @inlined
    def both(*arguments: object) -> None:
        first(*arguments)
        second(*arguments)

    return second if first is nothing else both


def _plus(first: Function, second: Function) -> Function:
    return inlined(lambda *arguments: first(*arguments) + second(*arguments))


def _or_more(first: Function, second: Function) -> Function:
    return inlined(lambda *arguments: max(first(*arguments), second(*arguments)))
