"""What a program does, apart from how it is written down: a hash of its syntax without comments and docstrings."""

from __future__ import annotations

import ast
import functools
import hashlib
import importlib.util
from collections.abc import Iterable
from pathlib import Path
from typing import Any

BELOW = frozenset({"stats.checks", "stats.results"})
"""Modules that most others use, and in part for words: of these only what a number rests on counts (`definitions`)."""


def digest(modules: Iterable[str]) -> str:
    """Hash the syntax of modules, whatever their order."""
    found = hashlib.sha256()
    for module in sorted(modules):
        found.update(f"{module}\n{_text(path_of(module).read_bytes())}\n".encode())
    return found.hexdigest()[:32]


def closure(module: str, package: str) -> set[str]:
    """A module and all that it imports of a package, directly or not, but for what lies below."""
    found: set[str] = set()
    waiting = {module}
    while waiting:
        name = waiting.pop()
        found.add(name)
        waiting |= {
            imported for imported in imports(name) if imported.startswith(f"{package}.") and imported not in BELOW
        } - found
    return found


@functools.cache
def imports(module: str) -> set[str]:
    """The modules that a module imports by name; whether one is a module or something in one is looked up."""
    found = set()
    for node in ast.walk(ast.parse(path_of(module).read_bytes())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            inside = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= {name for name in inside if is_module(name)} or {node.module}
    return found


def is_module(name: str) -> bool:
    package, _dot, last = name.rpartition(".")
    folder = Path(*package.split("."))
    return (_root() / folder / f"{last}.py").is_file() or (_root() / folder / last / "__init__.py").is_file()


def _root() -> Path:
    return Path(__file__).parents[2]


def path_of(module: str) -> Path:
    found = importlib.util.find_spec(module)
    assert found is not None, module
    assert found.origin is not None, module
    return Path(found.origin)


@functools.cache
def _text(source: bytes) -> str:
    return plain(ast.parse(source))


def plain(node: Any) -> str:
    """Write a tree as text; what differs between versions of Python (empty and absent fields) is left out."""
    if isinstance(node, list):
        return f"[{','.join(plain(item) for item in node if not _is_remark(item))}]"
    if not isinstance(node, ast.AST):
        return repr(node)
    fields = [
        f"{name}={plain(value)}"
        for name, value in ast.iter_fields(node)
        if value not in (None, []) and name not in ("ctx", "kind", "type_comment")
    ]
    return f"{type(node).__name__}({','.join(fields)})"


def _is_remark(node: Any) -> bool:
    """Docstrings, and strings that stand below what they explain."""
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
