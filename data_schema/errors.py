"""Every error that a user can cause.

    LabbookError              catch this one; a command prints its sentence and exits with its code
    ├── UsageError            2  wrong use: an option, a name, a value
    │   └── UnknownName       2  a name that does not exist here, with the nearest that does
    ├── InputRefused          2  a file or a statement that cannot be accepted as it is
    └── BookError             3  the book itself
        ├── BookMissing       2  no book here (nothing is damaged)
        ├── BookBusy          3  another program holds the book
        ├── BookReadOnly      3  who gave the command may not write to the book
        ├── BookVersion       3  has another schema, or was made by another program
        └── BookDamaged       3  what is stored contradicts itself

A disk that is full or fails is not the user's fault: 3, be it the book's or that of what is written beside it.
The message is one sentence: what was given, what is allowed or nearest, what to do.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable

_PASSWORD = re.compile(r"(://[^:/@]*:).*(?=@)|([?&]\w*password=)[^&]*", re.DOTALL)
_ADDRESS = re.compile(r"""(?<=')[\w+]+://[^']*|(?<=")[\w+]+://[^"]*|[\w+]+://\S+""")
"""An address in a sentence, to the quote that ends it or else to the next blank."""


def hide_password(url: str) -> str:
    """Return the address of a database with *** for its password, be it in `user:password@host` or an option."""
    return _PASSWORD.sub(lambda found: f"{found[1] or found[2]}***", url)


_LOOSE = re.compile(r"""(?<=:)[^\s:/@'"]+(?=@)|(?<=password=)[^\s&'"]+""")
"""A password in what was meant to be an address."""


def without_passwords(sentence: str) -> str:
    """Return what is said with *** for the passwords of the addresses in it, also of such as are no addresses."""
    return _LOOSE.sub("***", _ADDRESS.sub(lambda found: hide_password(found[0]), sentence))


class LabbookError(Exception):
    """Root of all errors that a user can cause; its text is the sentence shown, in which no password ever stands."""

    exit_code = 2

    def __str__(self) -> str:
        """Return the sentence."""
        return without_passwords(super().__str__())


class UsageError(LabbookError):
    """A command, option or argument was used in a way that has no meaning."""


class UnknownName(UsageError):
    """A name was given that does not exist where it was looked for."""


class InputRefused(LabbookError):
    """A file or statement cannot be accepted as it is; nothing was stored."""


class BookError(LabbookError):
    """The book cannot be used as it is."""

    exit_code = 3


class BookMissing(BookError):
    """There is no book at the given place."""

    exit_code = 2


class BookBusy(BookError):
    """Another program is writing to the book."""


class BookReadOnly(BookError):
    """Who gave the command may read the book and not write to it."""


class BookVersion(BookError):
    """The database was made by another version of labbook, or by another program."""


class BookDamaged(BookError):
    """What is stored contradicts itself."""


def disk_full(path: str = "") -> str:
    """Return the sentence for a disk that has no room for a file."""
    return f"the disk{f' of {path}' if path else ''} is full: make room on it, and give the command again."


SHORTENED = 3
"""Letters from which on a name counts as shortened; fewer begin many."""


def nearest(given: str, allowed: Iterable[str]) -> str | None:
    """Return the one allowed name that `given` begins, else the one that looks most like it; None when none is close.

    An ending left out is longer than most slips of the finger: without it `b_e` would look more like `b_g` than like
    `b_extension`. Zeros before a number change nothing: `r7` is `r007`, however much it looks like `r017`.
    """
    names = list(allowed)
    same = [name for name in names if _without_zeros(name) == _without_zeros(given)]
    if len(same) == 1:
        return same[0]
    folded = {name.lower(): name for name in names}
    begun = [name for name in folded if name.startswith(given.lower())] if len(given) >= SHORTENED else []
    if len(begun) == 1:
        return folded[begun[0]]
    match = difflib.get_close_matches(given.lower(), folded, n=1, cutoff=0.5)
    return folded[match[0]] if match else None


_ZEROS = re.compile(r"(?<![0-9.,])0+(?=[0-9])")
"""Those before a whole number."""


def _without_zeros(name: str) -> str:
    return _ZEROS.sub("", name.lower())


def unknown_name(what: str, given: str, allowed: Iterable[str], remedy: str = "") -> UnknownName:
    """Build the one sentence for a name that does not exist: given, nearest or allowed, what to do."""
    names = sorted(map(str, allowed))  # words of a closed list show as the words themselves
    close = nearest(given, names)
    if close is not None:
        hint = f"did you mean {close!r}?"
    elif not names:
        hint = f"there is no {what} yet."
    elif len(names) <= 12:
        hint = f"allowed are {', '.join(repr(name) for name in names)}."
    else:
        hint = f"there are {len(names)}, for example {', '.join(repr(name) for name in names[:5])}."
    return UnknownName(f"{given!r} is not a known {what}: {hint}{' ' + remedy if remedy else ''}")
