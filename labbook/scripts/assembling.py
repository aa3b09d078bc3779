"""One stand-alone file in Python, or in R, made of the parts of the templates that a number needs, as they stand there.

Settings, as the level of intervals, get the values of the number. Functions are called alike in both languages.
"""

from __future__ import annotations

import ast
import math
import pprint
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from labbook.scripts.facts import Script

FOLDER, R_FOLDER = Path(__file__).parent / "templates", Path(__file__).parent / "r"
TEMPLATES = ("runs", "days", "predictions")
"""In the order in which they stand in a script."""
_PACKAGE = "labbook.scripts.templates."
_WIDTH = 100


@dataclass(frozen=True, slots=True)
class Part:
    """A function, a class or a setting of a template: its lines, the names that it uses, and its section's heading."""

    name: str
    text: str
    uses: frozenset[str]
    heading: str


@cache
def statements_of(name: str) -> tuple[ast.stmt, ...]:
    """Return the statements of a template."""
    return tuple(ast.parse((FOLDER / f"{name}.py").read_text(encoding="utf-8")).body)


@cache
def parts_in_python() -> tuple[Part, ...]:
    """Return the parts of all templates; a text that follows no setting is the heading of what comes after it."""
    found: list[Part] = []
    for template in TEMPLATES:
        lines = (FOLDER / f"{template}.py").read_text(encoding="utf-8").splitlines()
        heading, of_setting = "", False
        for node in statements_of(template):
            text = "\n".join(lines[node.lineno - 1 : node.end_lineno])
            if isinstance(node, ast.Expr) and of_setting:
                found[-1] = replace(found[-1], text=f"{found[-1].text}\n{text}")
            elif isinstance(node, ast.Expr):
                heading = "# " + re.sub("\n+", "\n# ", str(ast.literal_eval(node.value)).rstrip())
            of_setting = isinstance(node, ast.Assign | ast.AnnAssign)
            if of_setting or isinstance(node, ast.FunctionDef | ast.ClassDef):
                names = [one for one in ast.walk(node) if isinstance(one, ast.Name | ast.arg)]
                own = {one.arg if isinstance(one, ast.arg) else one.id for one in names if not _is_read(one)}
                uses = {one.id for one in names if isinstance(one, ast.Name)} - own
                found.append(Part(re.findall(r"(?:def|class)? ?(\w+)[(:, ]", text)[0], text, frozenset(uses), heading))
    return tuple(found)


def _is_read(name: ast.Name | ast.arg) -> bool:
    return isinstance(name, ast.Name) and isinstance(name.ctx, ast.Load)


@cache
def parts_in_r() -> tuple[Part, ...]:
    """Return the parts of all templates in R, which are parted by blank lines; one of comments alone is a heading."""
    found, heading = [], ""
    for text in "\n".join((R_FOLDER / f"{name}.R").read_text(encoding="utf-8") for name in TEMPLATES).split("\n\n"):
        text = text.strip("\n")
        code = re.sub('#.*|"[^"]*"', "", text)
        own = re.findall(r"(\w+) <-", code)
        if own:
            read = re.findall(r"(?<![\w$.])\w+\b(?! *=(?!=))", code)  # neither columns nor names of arguments
            found.append(Part(own[0], text, frozenset(read) - set(own), heading))
        else:
            heading = text
    return tuple(found)


def needed_by(steps: Sequence[str], parts: Sequence[Part]) -> list[Part]:
    """Return the parts that functions need, in the order of a script."""
    by_name = {part.name: part for part in parts}
    found, left = set[str](), {"read", "show", *steps}
    while left:
        found |= left
        left = {use for name in left for use in by_name[name].uses if use in by_name} - found
    return [part for part in parts if part.name in found]


def _imported(parts: Sequence[Part]) -> list[str]:
    """Return the imports of what parts use, libraries last."""
    used, found = {use for part in parts for use in part.uses}, dict[str, set[str]]()
    for node in (node for name in TEMPLATES for node in statements_of(name)):
        if isinstance(node, ast.Import) and any((one.asname or one.name) in used for one in node.names):
            found[ast.unparse(node)] = set()
        elif isinstance(node, ast.ImportFrom) and not str(node.module).startswith(_PACKAGE):
            names = {one.name for one in node.names} & used
            if names:
                found.setdefault(f"from {node.module} import ", set()).update(names)
    in_order = sorted(found, key=lambda start: (start.split()[1].partition(".")[0] in ("numpy", "scipy"), start))
    return [f"{start}{', '.join(sorted(found[start]))}" for start in in_order]


def assemble(script: Script, heading: str, last_line: str) -> str:
    """Return the text of a Python file that reads the table beside it and prints the number.

    Parameters
    ----------
    script : what is computed, of which table
    heading : the docstring of the file
    last_line : what stands at the end, as a comment
    """
    parts = needed_by(script.steps, parts_in_python())
    text = "\n\n\n".join(["", *_texts(parts, script.settings)])
    quoted = heading.replace("\\", "\\\\").replace('"""', "'''")
    first, *further = script.steps
    main = [f'found = {first}(read("{script.table}"))', *(f"found = {step}(found)" for step in further), "show(found)"]
    return "\n".join(
        [f'"""{quoted}"""', "", *_imported(parts), f"{text}\n\n", 'if __name__ == "__main__":']
        + [f"    {line}" for line in main]
        + ["", f"# {last_line}", ""]
    )


def _texts(parts: Sequence[Part], settings: Mapping[str, object]) -> Iterator[str]:
    """Give the lines of parts, each section's heading first, and constants with the number's values."""
    said = ""
    for part in parts:
        if part.heading != said:
            yield (said := part.heading)
        if part.name not in settings:
            yield part.text
            continue
        value = settings[part.name]
        is_infinite = isinstance(value, float) and math.isinf(value)
        shown = f'float("{value}")' if is_infinite else pprint.pformat(value, width=_WIDTH, sort_dicts=False)
        yield "".join([f"{part.name} = {shown}", *part.text.partition('\n"""')[1:]])


def assemble_in_r(script: Script, heading: str, last_line: str) -> str:
    """Return the text of a file in R that does the same; parameters as of `assemble`, comments at head and end."""
    parts = needed_by(script.steps, parts_in_r())
    used = {"LEVEL", *(use for part in parts for use in part.uses)}
    named = [f"{name} <- {_in_r(value)}" for name, value in {"LEVEL": 0.95, **script.settings}.items() if name in used]
    comment = "\n".join(f"# {line}".rstrip() for line in heading.rstrip().splitlines())
    text = f'read("{script.table}")'
    for step in script.steps:
        text = f"{step}({text})"
    return "\n\n".join([comment, "\n".join(named), *_texts(parts, {}), f"show({text})", f"# {last_line}"]) + "\n"


def _in_r(value: object) -> str:
    """Write the value of a setting."""
    if isinstance(value, bool):
        return str(value).upper()
    if isinstance(value, float) and math.isinf(value):
        return "Inf" if value > 0.0 else "-Inf"
    if isinstance(value, Mapping):
        return f"list({', '.join(f'{_in_r(key)} = {_in_r(each)}' for key, each in value.items())})"
    if isinstance(value, tuple):
        kind = "c" if all(isinstance(each, str) for each in value) else "list"
        return f"{kind}({', '.join(map(_in_r, value))})"
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        return f'"{escaped}"'
    return repr(value)
