"""One stand-alone Python file made of functions of the templates: those that are asked for, and what these use.

Text is taken from the templates as it is. Settings, as the level of intervals, get the values of the number.
"""

from __future__ import annotations

import ast
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from labbook.scripts.script import Script

FOLDER = Path(__file__).parent / "templates"
TEMPLATES = (
    "runs",
    "shared",
    "joules",
    "heights",
    "measured",
    "position",
    "drain",
    "condition",
    "days",
    "equivalence",
    "two_samples",
    "anova",
    "contrasts",
    "hypotheses",
    "holm",
    "overall",
    "packs",
    "budget",
    "predictions",
    "simulated_changes",
    "biases",
)
"""In the order in which their functions stand in a script."""
_PACKAGE = "labbook.scripts.templates."
_WIDTH = 118


@dataclass(frozen=True)
class Template:
    """A template: what it is about, its statements by the names that they define, and where other names come from."""

    about: str
    lines: Sequence[str]
    defined: Mapping[str, ast.stmt]
    imported: Mapping[str, str]
    documented: Mapping[str, str] = field(default_factory=dict)

    def text_of(self, name: str) -> str:
        """Return the text of a definition, with what is said of it below."""
        node = self.defined[name]
        text = "\n".join(self.lines[node.lineno - 1 : node.end_lineno])
        return f'{text}\n"""{self.documented[name]}"""' if name in self.documented else text

    def used_by(self, name: str) -> set[str]:
        """Return the names that a definition uses."""
        return {node.id for node in ast.walk(self.defined[name]) if isinstance(node, ast.Name)}


@cache
def template(name: str) -> Template:
    """Read a template by its name."""
    source = (FOLDER / f"{name}.py").read_text(encoding="utf-8")
    tree = ast.parse(source)
    defined: dict[str, ast.stmt] = {}
    imported: dict[str, str] = {}
    documented: dict[str, str] = {}
    last: list[str] = []
    for node in tree.body:
        names = list(_names_of(node))
        defined |= dict.fromkeys(names, node)
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            documented |= dict.fromkeys(last[:1], str(node.value.value))
        if isinstance(node, ast.Import | ast.ImportFrom):
            imported |= dict(_imports_of(node))
        last = names
    about = ast.get_docstring(tree) or ""
    return Template(about, source.splitlines(), defined, imported, documented)


def _names_of(node: ast.stmt) -> Iterator[str]:
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        yield node.name
    targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
    for target in targets:
        yield from (each.id for each in ast.walk(target) if isinstance(each, ast.Name))


def _imports_of(node: ast.Import | ast.ImportFrom) -> Iterator[tuple[str, str]]:
    """Give each name that an import defines, with the import of it alone."""
    for alias in node.names:
        renamed = f" as {alias.asname}" if alias.asname else ""
        start = f"from {node.module} " if isinstance(node, ast.ImportFrom) else ""
        yield alias.asname or alias.name, f"{start}import {alias.name}{renamed}"


def _home_of(name: str, where: str) -> str | None:
    """Return the template that defines a name which another one uses; None of a library's, or Python's own."""
    here = template(where)
    if name in here.defined:
        return where
    statement = here.imported.get(name, "")
    return statement.removeprefix(f"from {_PACKAGE}").split()[0] if _PACKAGE in statement else None


def needed_by(functions: Sequence[str]) -> dict[str, set[str]]:
    """Return by template the names that some functions, called `template.function`, need."""
    needed: dict[str, set[str]] = {}
    open_names = [tuple(each.split(".")) for each in functions]
    while open_names:
        where, name = open_names.pop()
        if name in needed.setdefault(where, set()):
            continue
        needed[where].add(name)
        for used in template(where).used_by(name):
            home = _home_of(used, where)
            if home is not None:
                open_names.append((home, used))
    return needed


def assemble(script: Script, heading: str, last_line: str) -> str:
    """Return the text of a Python file that reads the table beside it and prints the number.

    Parameters
    ----------
    script : what is computed, of which table
    heading : the docstring of the file
    last_line : what stands at the end, as a comment
    """
    needed = needed_by(["runs.read", *script.steps, "runs.show"])
    used = {used for where, names in needed.items() for name in names for used in template(where).used_by(name)}
    quoted = heading.replace("\\", "\\\\").replace('"""', "'''")
    parts = [f'"""{quoted}"""', *_imports(needed, used)]
    for where, name in _settings(needed, script.settings):
        meaning = template(where).documented[name]
        parts.append(f'{name} = {_shown(script.settings[name], head=len(name) + 3)}\n"""{meaning}"""')
    for where in TEMPLATES:
        names = [name for name in template(where).defined if name in needed.get(where, ())]
        own = [name for name in names if name not in script.settings]
        if own:
            parts.append(f"# {template(where).about}".replace("\n\n", "\n").replace("\n", "\n# "))
            parts += dict.fromkeys(template(where).text_of(name) for name in own)
    return _joined([*parts, _main(script), f"# {last_line}"])


def _joined(parts: Sequence[str]) -> str:
    """Join parts with the blank lines that functions and classes have around them."""
    text = ""
    for before, part in zip(("", *parts), parts, strict=False):
        far = any(each.startswith(("def ", "class ", "if __name__")) for each in (before, part))
        blank = "\n\n\n" if far else "\n\n"
        text += f"{blank if before else ''}{part}"
    return f"{text}\n"


def _imports(needed: Mapping[str, set[str]], used: set[str]) -> Iterator[str]:
    """Give the imports of the standard library, then those of numpy and scipy."""
    statements: set[str] = set()
    for where in needed:
        imported = template(where).imported
        statements |= {imported[name] for name in used & imported.keys() if _PACKAGE not in imported[name]}
    named: dict[str, list[str]] = {}
    for statement in sorted(statements):
        start, _import, name = statement.partition("import ")
        named.setdefault(start, []).append(name)
    lines = [f"import {name}" for name in named.pop("", [])]
    lines += [f"{start}import {', '.join(names)}" for start, names in named.items()]
    libraries = [line for line in lines if line.split()[1].split(".")[0] in ("numpy", "scipy")]
    for some in ([line for line in lines if line not in libraries], libraries):
        if some:
            yield "\n".join(some)


def _settings(needed: Mapping[str, set[str]], settings: Mapping[str, object]) -> Iterator[tuple[str, str]]:
    """Give the settings that the needed functions use, with the template that declares each."""
    for where in TEMPLATES:
        for name in template(where).defined:
            if name in settings and name in needed.get(where, ()):
                yield where, name


def _shown(value: object, indent: int = 0, head: int = 0) -> str:
    """Write the value of a setting: on one line where it fits behind `head` characters, else an item a line."""
    if isinstance(value, float) and math.isinf(value):
        return f'float("{value}")'
    if not isinstance(value, tuple | dict):
        return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)
    keys = [f"{_shown(key)}: " for key in value] if isinstance(value, dict) else [""] * len(value)
    items = value.values() if isinstance(value, dict) else value
    start, end = "{}" if isinstance(value, dict) else "()"
    flat = ", ".join(f"{key}{_shown(item)}" for key, item in zip(keys, items, strict=True))
    flat = f"{start}{flat}{',' if start == '(' and len(value) == 1 else ''}{end}"
    if head + indent + len(flat) <= _WIDTH:
        return flat
    inner = " " * (indent + 4)
    lines = [f"{inner}{key}{_shown(item, indent + 4, len(key))}," for key, item in zip(keys, items, strict=True)]
    return "\n".join([start, *lines, f"{' ' * indent}{end}"])


def _main(script: Script) -> str:
    first, *further = [each.split(".")[1] for each in script.steps]
    lines = [f'    found = {first}(read("{script.table}"))', *(f"    found = {step}(found)" for step in further)]
    lines[-1] = lines[-1].replace("    found = ", "    show(", 1) + ")"
    return "\n".join(['if __name__ == "__main__":', *lines])
