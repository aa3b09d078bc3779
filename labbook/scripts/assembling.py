"""One stand-alone Python file made of the templates that a number needs, below each other as they stand.

Settings, as the level of intervals, get the values of the number.
"""

from __future__ import annotations

import ast
import math
import pprint
from collections.abc import Mapping, Sequence
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
"""In the order in which they stand in a script."""
_PACKAGE = "labbook.scripts.templates."
_WIDTH = 100


def source_of(name: str) -> str:
    """Return the text of a template."""
    return (FOLDER / f"{name}.py").read_text(encoding="utf-8")


@cache
def statements_of(name: str) -> tuple[ast.stmt, ...]:
    """Return the statements of a template."""
    return tuple(ast.parse(source_of(name)).body)


def needed_by(steps: Sequence[str]) -> list[str]:
    """Return the templates that functions, called `template.function`, need, in the order of a script."""
    found, left = set[str](), {"runs", *(step.partition(".")[0] for step in steps)}
    while left:
        found |= left
        imported = (
            node.module or "" for name in left for node in statements_of(name) if isinstance(node, ast.ImportFrom)
        )
        left = {module.removeprefix(_PACKAGE) for module in imported if module.startswith(_PACKAGE)} - found
    return [name for name in TEMPLATES if name in found]


def assemble(script: Script, heading: str, last_line: str) -> str:
    """Return the text of a Python file that reads the table beside it and prints the number.

    Parameters
    ----------
    script : what is computed, of which table
    heading : the docstring of the file
    last_line : what stands at the end, as a comment
    """
    imports: dict[str, set[str]] = {}
    text = ""
    for name in needed_by(script.steps):
        lines, (about, *statements) = source_of(name).splitlines(), statements_of(name)
        said = ast.literal_eval(about.value) if isinstance(about, ast.Expr) else ""
        text += "\n\n\n# " + said.rstrip().replace("\n\n", "\n").replace("\n", "\n# ")
        for node in statements:
            if isinstance(node, ast.Import):
                imports[ast.unparse(node)] = set()
            elif isinstance(node, ast.ImportFrom):
                if not str(node.module).startswith(_PACKAGE):
                    imports.setdefault(f"from {node.module} import ", set()).update(one.name for one in node.names)
            else:
                text += _before(node) + (
                    _setting(node, script.settings) or "\n".join(lines[node.lineno - 1 : node.end_lineno])
                )
    imported = [f"{start}{', '.join(sorted(names))}" for start, names in sorted(imports.items(), key=_libraries_last)]
    quoted = heading.replace("\\", "\\\\").replace('"""', "'''")
    first, *further = [each.split(".")[1] for each in script.steps]
    main = [f'found = {first}(read("{script.table}"))', *(f"found = {step}(found)" for step in further), "show(found)"]
    return "\n".join(
        [f'"""{quoted}"""', "", *imported, f"{text}\n\n", 'if __name__ == "__main__":']
        + [f"    {line}" for line in main]
        + ["", f"# {last_line}", ""]
    )


def _libraries_last(item: tuple[str, set[str]]) -> tuple[bool, str]:
    return item[0].split()[1].partition(".")[0] in ("numpy", "scipy"), item[0]


def _before(node: ast.stmt) -> str:
    """Return the blank lines before a statement; what is said of a name stands right below it."""
    return (
        "\n" if isinstance(node, ast.Expr) else "\n\n\n" if isinstance(node, ast.FunctionDef | ast.ClassDef) else "\n\n"
    )


def _setting(node: ast.stmt, settings: Mapping[str, object]) -> str:
    """Return a template's constant with the number's value; "" for another statement."""
    targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
    for target in targets:
        if isinstance(target, ast.Name) and target.id in settings:
            value = settings[target.id]
            is_infinite = isinstance(value, float) and math.isinf(value)
            shown = f'float("{value}")' if is_infinite else pprint.pformat(value, width=_WIDTH, sort_dicts=False)
            return f"{target.id} = {shown}"
    return ""
