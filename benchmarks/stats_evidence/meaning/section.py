"""The section on what all this means for someone with runs to compare."""

from __future__ import annotations

TEXT = """\
## What it means

Means, scatter, t, F, their p and the coefficients of fits are what exact arithmetic gives on the values handed over, to
the last digit or nearly; ends of intervals rest on quantiles, of which Student's is the nearest double or its neighbour
and others are good to twelve or more digits, mixed models and resampling on searches and draws. It does not matter how
far the values lie from 0, in which unit they are, or in which order: heights in counts of an encoder, times in seconds
since 1970 and sums of millijoules keep all their digits. Whole numbers and decimals are taken as they are, so that a
column of a logger loses nothing on its way through a double either.

For a few dozen runs with an offset of no more than a thousand times their scatter every library here gives t and F to
ten digits or more, and nobody prints more than four. Choose among them by what they offer then, not by digits. The
digits matter where a study gets near an edge: an offset of a million times the scatter leaves scipy's t nine of fifteen
digits, 1e12 times leave it three, and a bare least-squares solver has none of a slope over raw time stamps. What is
dangerous there is that the result looks like any other. The section on where other programs err has such cases; labbook
answers each with the right number, or with a sentence that says why there is none.

More than digits it matters that a test keeps what it promises. A test of 5 % that rejects one time in nine, or an
interval of 95 % that holds the truth seven times in eight, is wrong in the first digit. The section on size and
coverage gives what each method here does with few values, unequal scatter and runs from a few days; a report that uses
a method where it fails says so.

The price is small: comparing two groups of 25 runs by F, Student and Welch takes less than a millisecond, about as
long as scipy takes for the same fields. Where others were measured to be faster the tables on speed say by how much.
For simulations that call a test a million times plain numpy is the better tool, and labbook's own use it.
"""


def section() -> list[str]:
    """Return the section as lines of Markdown."""
    return TEXT.splitlines()
