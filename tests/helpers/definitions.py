"""All that a number rests on, name by name: functions, classes and constants, and whatever these name in turn.

A whole module would be too much, because what only words a report or reads a result back lies beside what computes.
What words a sentence (methods called `sentence`) or a refusal (what stands behind `raise`) is no part of a definition.
"""

from __future__ import annotations

import ast
import functools
import hashlib
from collections.abc import Iterable, Iterator, Set
from dataclasses import dataclass
from typing import TypeAlias

from tests.helpers.sources import is_module, path_of, plain

Definition: TypeAlias = tuple[str, str]
"""A module and a name in it; "" are the statements of a module that define nothing."""

OWN = ("data_schema", "ingest", "labbook", "reports", "simulator", "stats")
LEFT_OUT = {
    "data_schema.errors": "words refusals",
    "data_schema.journal": "writes what keys are hashes of: other text, other keys",
    "data_schema.queries": "reads facts, each of which is an input of a result and in its key",
    "data_schema.tables": "the same",
    "ingest": "reads samples, which are inputs by their hash, and has versions of its own",
    "labbook.analysis.algorithms": "lists what is watched",
    "labbook.analysis.study_data": "chooses the facts that become inputs",
    "labbook.analysis.outcomes.detection.Detections": "gives what a detector found, which has a version of its own",
    "labbook.config": "reads settings, which are in the key of a result",
}
"""What is not followed, a package, a module or a definition, and why no number changes its meaning with it."""
WHOLE = ("simulator.",)
"""Packages of which a module counts as a whole: effects are found by their place in a registry, not by name."""


@dataclass(frozen=True)
class _Module:
    """A module taken apart: statements by the name that they define, and where imported names come from."""

    statements: dict[str, list[ast.stmt]]
    imported: dict[str, Definition]


def digest_of(definitions: Iterable[Definition]) -> str:
    """Hash definitions, whatever their order."""
    found = hashlib.sha256()
    for one in sorted(definitions):
        found.update(_text(one))
    return found.hexdigest()[:32]


@functools.cache
def _text(one: Definition) -> bytes:
    module, name = one
    return f"{module}.{name}\n{plain(_module(module).statements[name])}\n".encode()


def rests_on(roots: Iterable[Definition]) -> set[Definition]:
    """Return definitions and all that they name, directly or not, in the modules that are followed."""
    found: set[Definition] = set()
    waiting = set(roots)
    while waiting:
        one = waiting.pop()
        found.add(one)
        waiting |= {named for named in named_by(one) if not _left_out(named)} - found
    return found


@functools.cache
def defined_in(module: str) -> frozenset[Definition]:
    """Return everything that a module defines."""
    return frozenset((module, name) for name in _module(module).statements)


@functools.cache
def attributes_in(one: Definition) -> set[str]:
    """Return what a definition takes from objects and modules: the names behind dots."""
    statements = _module(one[0]).statements[one[1]]
    nodes = [node for statement in statements for node in ast.walk(statement)]
    return {node.attr for node in nodes if isinstance(node, ast.Attribute)}


def forget() -> None:
    """Read modules anew."""
    for cached in (_module, _text, _looked_up, defined_in, attributes_in, named_by):
        cached.cache_clear()


@functools.cache
def _left_out(one: Definition) -> bool:
    full = ".".join(filter(None, one))
    return full.partition(".")[0] not in OWN or any(full == part or full.startswith(f"{part}.") for part in LEFT_OUT)


@functools.cache
def named_by(one: Definition) -> frozenset[Definition]:
    """Return the definitions that a definition names itself."""
    module, name = one
    about = _module(module)
    places = {place for statement in about.statements[name] for place in _places(statement, about.imported)}
    found = {definition for place in places for definition in _definitions_of(module, *place)}
    if module.startswith(WHOLE):
        found |= defined_in(module)
        found |= {each for origin in about.imported.values() for each in _looked_up(*origin)}
    return frozenset(found | ({(module, "")} if "" in about.statements else set()))


def _places(statement: ast.stmt, imported: dict[str, Definition]) -> Iterator[tuple[str, str]]:
    """Return the names in a statement, each with what is taken from it where it is a module."""
    for node in ast.walk(statement):
        if isinstance(node, ast.Name):
            yield node.id, ""
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in imported:
            yield node.value.id, node.attr


def _definitions_of(module: str, name: str, attribute: str) -> Set[Definition]:
    about = _module(module)
    if name in about.statements:
        return {(module, name)}
    if name not in about.imported:
        return set()
    origin, inside = about.imported[name]
    if inside:
        return _looked_up(origin, inside)
    return _looked_up(origin, attribute) if attribute else set()  # of a module no more than what is taken from it


@functools.cache
def _looked_up(module: str, name: str) -> Set[Definition]:
    """Return where a name of a module is defined: there, or where that has it from."""
    if _left_out((module, name)):
        return set()
    about = _module(module)
    if name in about.statements:
        return {(module, name)}
    if not name:
        return defined_in(module)
    return _looked_up(*about.imported[name]) if name in about.imported else set()


@functools.cache
def _module(name: str) -> _Module:
    tree = ast.parse(path_of(name).read_bytes())
    imported = {local: origin for node in ast.walk(tree) for local, origin in _imports(node)}
    statements: dict[str, list[ast.stmt]] = {}
    for statement in tree.body:
        if _says_nothing(statement):
            continue
        for defined in _defines(statement) or [""]:
            statements.setdefault(defined, []).append(_Wordless().visit(statement))
    return _Module(statements, imported)


def _imports(node: ast.AST) -> Iterator[tuple[str, Definition]]:
    if isinstance(node, ast.Import):
        for alias in node.names:
            yield (alias.asname, (alias.name, "")) if alias.asname else (alias.name.partition(".")[0], (alias.name, ""))
    elif isinstance(node, ast.ImportFrom) and node.module:
        for alias in node.names:
            inside = f"{node.module}.{alias.name}"
            yield alias.asname or alias.name, (inside, "") if is_module(inside) else (node.module, alias.name)


def _defines(statement: ast.stmt) -> list[str]:
    if isinstance(statement, ast.FunctionDef | ast.ClassDef):
        return [statement.name]
    targets = statement.targets if isinstance(statement, ast.Assign) else [getattr(statement, "target", None)]
    return [node.id for target in targets if target is not None for node in ast.walk(target) if type(node) is ast.Name]


def _says_nothing(statement: ast.stmt) -> bool:
    """Imports, remarks, imports for types, and the numbers of versions."""
    if isinstance(statement, ast.If):
        return all(map(_says_nothing, [*statement.body, *statement.orelse]))
    if isinstance(statement, ast.Expr):
        return isinstance(statement.value, ast.Constant)
    return isinstance(statement, ast.Import | ast.ImportFrom)


class _Wordless(ast.NodeTransformer):
    """Takes out what only words: sentences, and the text of refusals. A version's number is no source either."""

    def visit_ClassDef(self, node: ast.ClassDef) -> ast.AST:
        node.body = [part for part in node.body if not (isinstance(part, ast.FunctionDef) and part.name == "sentence")]
        return self.generic_visit(node)

    def visit_Raise(self, node: ast.Raise) -> ast.AST:
        kind = node.exc.func if isinstance(node.exc, ast.Call) else node.exc
        return ast.Raise(exc=kind)

    def visit_Call(self, node: ast.Call) -> ast.AST:
        if isinstance(node.func, ast.Name) and node.func.id == "Algorithm":
            return ast.Call(func=node.func, args=[], keywords=[])
        return self.generic_visit(node)
