"""The section on correct digits: all of NIST's sets, and what a common offset costs."""

from __future__ import annotations

import importlib.metadata

from benchmarks.section import Table
from benchmarks.stats_evidence.digits import anova, offsets, regression, univariate
from benchmarks.stats_evidence.digits.lre import NO_NUMBER
from benchmarks.stats_evidence.prose import filled, table_lines

LIBRARIES = ("numpy", "scipy", "statsmodels", "pingouin")

INTRODUCTION = """\
Digits are -log10 of the relative error, at least 0 and at most 15, against exact arithmetic on the same doubles: NIST's
certified values hold for its decimals, and rounding these to doubles alone costs SmLs07 to 09 eleven digits, which no
program can give back. Where the exact value is 0 (standard errors of Wampler1) the error itself counts. "{none}" is
NaN, infinity or an error; an empty cell is a quantity that the program does not offer. Compared with {versions}. Linear
algebra for another processor moves the digits of the others by up to two, and none of labbook's: that was tried with
five of OpenBLAS's kernels.
"""

OF_P = """\
* p of SmLs03, 06 and 09 is about 1e-2477, below every double: there the digits of log10 p count. The libraries return
p = 0, whose logarithm is no number.
"""

OF_FITS = """\
labbook fits Norris, Pontius, Filip and Wampler's sets by `fit_polynomial` from x and the degree, NoInt and Longley by
`fit_linear`; polyfit gets x and the degree too, the others a matrix of powers. Filip's powers rounded to doubles cap
every program that is given them at about 8 digits. What scatters in Wampler2 is the rounding of its decimals alone,
1e-16 of y, and no other program sees so little.
"""

OF_OFFSETS = """\
Student's t-test of {size} and {size} values, standard deviation 1, difference {shift:g}, all raised by the same offset:
the worst of {drawings} drawings.
"""


def section() -> list[str]:
    """Return the section as lines of Markdown; the same on every call."""
    versions = ", ".join(f"{name} {importlib.metadata.version(name)}" for name in LIBRARIES)
    of_offsets = OF_OFFSETS.format(size=offsets.SIZE, shift=offsets.SHIFT, drawings=offsets.DRAWINGS)
    return [
        "## Correct digits",
        "",
        *filled(INTRODUCTION.format(none=NO_NUMBER, versions=versions)),
        "",
        "### Univariate sets",
        "",
        *_shown(univariate.tables()),
        "### Analysis of variance",
        "",
        *_shown(anova.tables()),
        *filled(OF_P),
        "",
        "### Linear regression",
        "",
        *filled(OF_FITS),
        "",
        *_shown(regression.tables()),
        "### Two samples with a common offset",
        "",
        *filled(of_offsets),
        "",
        *_shown(offsets.tables()),
    ]


def _shown(tables: list[Table]) -> list[str]:
    return [line for table in tables for line in (*table_lines(table), "")]
