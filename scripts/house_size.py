"""Print the size of the house: lines, tokens, files and circles of imports, by package.

Lines are all lines of the Python files. Tokens are Python's own, without comments, docstrings
and blanks. A circle is a set of files that import each other, imports within functions included.
"""

import ast
import io
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

PACKAGES = ("labbook", "reports", "ingest", "stats", "simulator", "data_schema")
BESIDE = ("tests", "benchmarks", "scripts")
NOT_COUNTED = {
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENCODING,
    tokenize.ENDMARKER,
}
ROOT = Path(__file__).resolve().parent.parent


def count_tokens(source: str) -> int:
    """Count the tokens of a Python source without comments, docstrings and blanks."""
    docstrings = {
        (node.body[0].lineno, node.body[0].col_offset)
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef)
        and ast.get_docstring(node, clean=False) is not None
    }
    return sum(
        token.type not in NOT_COUNTED and token.start not in docstrings
        for token in tokenize.generate_tokens(io.StringIO(source).readline)
    )


def imported_modules(source: str, module: str, is_package: bool) -> Iterator[str]:
    """Yield the dotted names that a source imports, in functions too."""
    package = module if is_package else module.rpartition(".")[0]
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            parts = package.split(".")[: len(package.split(".")) - max(node.level - 1, 0)]
            start = ".".join([*(parts if node.level else []), *filter(None, [node.module])])
            for alias in node.names:
                yield f"{start}.{alias.name}"


def circles(files: dict[str, Path]) -> list[list[str]]:
    """Find the sets of modules that import each other, the largest first."""
    names = list(files)
    index = {name: number for number, name in enumerate(names)}
    edges: set[tuple[int, int]] = set()
    for name, path in files.items():
        is_package = path.name == "__init__.py"
        for imported in imported_modules(path.read_text(), name, is_package):
            target = imported if imported in index else imported.rpartition(".")[0]
            if target in index and target != name:
                edges.add((index[name], index[target]))
    rows, columns = zip(*edges, strict=True)
    graph = csr_array((np.ones(len(edges)), (rows, columns)), shape=(len(names), len(names)))
    _, labels = connected_components(graph, directed=True, connection="strong")
    groups = [
        [name for name, label in zip(names, labels, strict=True) if label == group]
        for group in np.flatnonzero(np.bincount(labels) > 1)
    ]
    return sorted(groups, key=len, reverse=True)


def main() -> None:
    """Print a table of the packages, then the circles."""
    files: dict[str, Path] = {}
    total = np.zeros(3, dtype=int)
    print(f"{'package':<12}{'lines':>9}{'tokens':>9}{'files':>7}")
    for package in (*PACKAGES, "", *BESIDE):
        if not package:
            print("{:<12}{:>9}{:>9}{:>7}".format("product", *total))
            continue
        paths = sorted((ROOT / package).rglob("*.py"))
        sources = [path.read_text() for path in paths]
        size = (
            sum(len(source.splitlines()) for source in sources),
            sum(count_tokens(source) for source in sources),
            len(paths),
        )
        print("{:<12}{:>9}{:>9}{:>7}".format(package, *size))
        if package in PACKAGES:
            total += size
            for path in paths:
                parts = path.relative_to(ROOT).with_suffix("").parts
                files[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    found = circles(files)
    print(f"circles of imports: {len(found)}; files in each: {[len(group) for group in found]}")
    if "-v" in sys.argv:
        for group in found:
            print("  " + ", ".join(sorted(group)))


if __name__ == "__main__":
    main()
