"""Regular expressions that a person writes into `labbook.toml`: whether they are any, and end in bounded time.

Python's matcher tries ways of matching one after the other. A repeat inside a repeat, as in `(\\d+)*`, many optional
letters or several wildcards in a row have more ways than anybody waits for, on a name that does not match. The ways are
bounded from above, as a number of bits, by the signs of the pattern alone.
"""

from __future__ import annotations

import math
import re

MOST_LETTERS = 500
_LONGEST_NAME = 255
MOST_BITS = 26
"""Three wildcards in a row, and two choices: seconds on the longest name, where it does not match."""

_SIGN = re.compile(
    r"""\\.|\[\^?\]?(?:\\.|[^\]\\])*\]        # an escaped letter, a set of letters
    |\(\?[aiLmsu-]*\)                        # flags
    |\(\?P?<\w+>|\(\?(?:<?[=!]|[aiLmsu-]*:|>)|[()]  # groups
    |[*+?][?+]?|\{\d*,?\d*\}[?+]?           # repeats
    |.""",
    re.DOTALL | re.VERBOSE,
)
_REPEAT = re.compile(r"(?P<sign>[*+?])[?+]?|\{(?P<least>\d*)(?P<comma>,?)(?P<most>\d*)\}[?+]?")
_VERBOSE = re.compile(r"\(\?[aiLmsu]*x")
_NO_LETTER = re.compile(r"[|(^)]|\\[AbB0-9]|\(\?")
_LETTERS = "".join(map(chr, range(256))) + "\u03bb\u0416\u4e2d\u0663"


def pattern_fault(pattern: str, in_force: bool) -> str | None:
    """Return what is wrong with a pattern for a run's name, or None; one that is `in_force` may be slow."""
    try:
        if "run" not in re.compile(pattern).groupindex:
            return f"{pattern!r} has no group (?P<run>...): put one round the run's name."
    except (re.error, RecursionError, OverflowError) as error:
        return f"{pattern!r} is not a regular expression ({error}): correct it."
    if in_force:
        return None
    if len(pattern) > MOST_LETTERS:
        return f"the pattern has {len(pattern)} characters, more than {MOST_LETTERS}: shorten it."
    return _slow(pattern)


def _slow(pattern: str) -> str | None:
    if _VERBOSE.search(pattern):
        return f"{pattern!r} has the flag x: write it without, and without blanks between its signs."
    signs = _SIGN.findall(pattern)
    ways = [0.0]  # of each open group, in bits
    alternatives = [1]
    for place, sign in enumerate(signs):
        least, most = _counts(signs, place + 1)
        if sign.startswith("(") and not sign.endswith(")"):
            ways.append(0.0)
            alternatives.append(1)
        elif sign == ")" and len(ways) > 1:
            inside = ways.pop() + math.log2(alternatives.pop())
            ways[-1] += most * inside + math.log2(most - least + 1)
        elif sign == "|":
            alternatives[-1] += 1
        elif most > least and not _ends_in_one_way(signs, place):
            ways[-1] += math.log2(most - least + 1)
    bits = sum(ways) + sum(map(math.log2, alternatives))
    if bits > MOST_BITS:
        return (
            f"{pattern!r} can match a name in 2 to the power of {bits:.0f} ways, which takes too long: name the "
            "letters between its wildcards, and repeat no group that repeats or has alternatives itself."
        )
    return None


def _counts(signs: list[str], place: int) -> tuple[int, int]:
    """Return how often at least and at most the repeat at `place` takes what is before it; once where none is there."""
    found = _REPEAT.fullmatch(signs[place]) if place < len(signs) else None
    if found is None:
        return 1, 1
    if found["sign"]:
        return int(found["sign"] == "+"), 1 if found["sign"] == "?" else _LONGEST_NAME
    least = int(found["least"] or 0)
    most = _LONGEST_NAME if found["comma"] and not found["most"] else int(found["most"] or least)
    return min(least, _LONGEST_NAME), min(most, _LONGEST_NAME)


def _ends_in_one_way(signs: list[str], place: int) -> bool:
    """Whether what follows the repeat of a letter or set shows where it ends: the pattern's end, or another letter."""
    taken = _letters(signs[place])
    after = place + 2
    while after < len(signs) and signs[after] not in ("$", r"\Z"):
        least, most = _counts(signs, after + 1)
        if signs[after] == ")" and (least, most) == (1, 1):
            after += 1
        elif _NO_LETTER.match(signs[after]) or taken & _letters(signs[after]):
            return False
        elif least:
            return True
        else:
            after += 2
    return True


def _letters(sign: str) -> set[str]:
    """Return what a letter or set matches, whether or not letters of either case are one."""
    return {letter for flags in (re.DOTALL, re.DOTALL | re.IGNORECASE) for letter in re.findall(sign, _LETTERS, flags)}
