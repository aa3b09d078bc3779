"""The entry of the command `labbook`: a Ctrl-C ends it with one sentence, also while it still starts."""

from __future__ import annotations

import gc
import os
import signal
import sys
from types import FrameType
from typing import NoReturn

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells have it."""


def main() -> NoReturn:
    """Run the command line; what it needs is imported here, because half of its time goes into that.

    Python and libraries may raise another error in place of a Ctrl-C that they meet: what ends a command after one is
    the Ctrl-C all the same.
    """
    pressed = []

    def on_interrupt(_signal: int, _frame: FrameType | None) -> NoReturn:
        pressed.append(True)
        raise KeyboardInterrupt

    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # else it is to be ignored, as under nohup
        signal.signal(signal.SIGINT, on_interrupt)
    try:
        from labbook.cli.main import run

        run()
    except SystemExit as end:
        if end.code == INTERRUPTED:
            print_interrupted()
        gc.freeze()  # Python looks for cycles twice as it ends: a tenth of a report's time, for memory that goes anyway
        raise
    except BaseException as error:
        if not pressed and not isinstance(error, KeyboardInterrupt):
            raise
        print_interrupted()
        sys.stderr.flush()
        os._exit(INTERRUPTED)  # half of an import may be left behind, at which closing in order would stumble


def print_interrupted() -> None:
    """Print that the command was interrupted, and what that means for the book."""
    print("labbook: interrupted; what was finished before is kept, what was not is left out.", file=sys.stderr)
