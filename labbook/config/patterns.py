"""Regular expressions that a person writes into `labbook.toml`: whether they are any, and end in bounded time.

Python's matcher tries ways of matching one after the other. A repeat inside a repeat, as in `(\\d+)*`, or several
wildcards in a row have more ways than anybody waits for, on a name that does not match.
"""

from __future__ import annotations

import re

MOST_LETTERS = 500
MOST_WILDCARDS = 3
"""On a name of 255 letters, each further one multiplies the tries by 255."""

_SIGN = re.compile(
    r"""\\.|\[\^?\]?(?:\\.|[^\]\\])*\]        # an escaped letter, a set of letters
    |\(\?[aiLmsux-]*\)                       # flags
    |\(\?P?<\w+>|\(\?(?:<?[=!]|[aiLmsux-]*:|>)|[()]  # groups
    |\||[*+?][?+]?|\{\d*,?\d*\}[?+]?|.""",
    re.DOTALL | re.VERBOSE,
)
_WILDCARDS = (".", r"\w", r"\W", r"\S", r"\D", "[^")


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
    signs = _SIGN.findall(pattern)
    varies = [False]  # of each open group: whether it can match in several ways
    wildcards = 0
    for before, sign, after in zip(["", *signs], signs, [*signs[1:], ""], strict=False):
        repeated = _repeats(after)
        if sign.startswith("(") and not sign.endswith(")"):
            varies.append(False)
        elif sign == ")" and len(varies) > 1:
            inside = varies.pop()
            if inside and repeated:
                return f"{pattern!r} repeats a group that itself repeats or has alternatives: write it without one."
            varies[-1] |= inside
        elif sign == "|" or (_repeats(sign) and before) or sign in ("?", "??", "?+"):
            varies[-1] = True
        elif repeated and (sign.startswith(_WILDCARDS) or _repeats(before)):
            wildcards += 1
    if wildcards > MOST_WILDCARDS:
        return f"{pattern!r} repeats {wildcards} wildcards, more than {MOST_WILDCARDS}: name the letters between them."
    return None


def _repeats(sign: str) -> bool:
    """Whether a sign repeats what is before it without a small bound."""
    counted = re.match(r"\{(\d*)(,?)(\d*)\}", sign)
    if counted:
        return int(counted[3] or (counted[1] if not counted[2] else 0) or 10**6) > 20
    return sign[:1] in ("*", "+")
