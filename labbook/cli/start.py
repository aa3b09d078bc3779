"""The entry of the command `labbook`: a Ctrl-C ends it with one sentence, also while it still starts."""

from __future__ import annotations

import contextlib
import gc
import os
import signal
import sys
from types import FrameType
from typing import NoReturn

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells have it."""
MOST_TO_END_S = 20.0
"""So long after a Ctrl-C a command may still put things in order, and then ends whatever it waits for."""
AGAIN_S = 0.01


def main() -> NoReturn:
    """Run the command line; what it needs is imported here, because half of its time goes into that.

    Python and libraries may raise another error in place of a Ctrl-C that they meet: what ends a command after one is
    the Ctrl-C all the same. One that meets a destructor, where Python lets nothing through, comes again. No thread is
    started for it: a Ctrl-C may come while this one holds what starting another needs.
    """
    pressed: list[bool] = []
    lost: list[bool] = []

    def on_interrupt(_signal: int, _frame: FrameType | None) -> NoReturn:
        pressed.append(True)
        wake_in(MOST_TO_END_S)
        raise KeyboardInterrupt

    def on_lost_error(error: sys.UnraisableHookArgs) -> None:
        if pressed and issubclass(error.exc_type, KeyboardInterrupt):
            lost.append(True)
            wake_in(AGAIN_S)  # not from here, where it would be lost as well
        else:
            sys.__unraisablehook__(error)

    def on_alarm(_signal: int, _frame: FrameType | None) -> NoReturn:
        if not lost:
            end_now()
        lost.clear()
        wake_in(MOST_TO_END_S)
        raise KeyboardInterrupt

    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # else it is to be ignored, as under nohup
        signal.signal(signal.SIGINT, on_interrupt)
        sys.unraisablehook = on_lost_error
        if hasattr(signal, "SIGALRM"):
            signal.signal(signal.SIGALRM, on_alarm)
    try:
        from labbook.cli.main import run

        run()
    except SystemExit as end:
        wake_in(0.0)
        if end.code == INTERRUPTED:
            print_interrupted()
        gc.freeze()  # Python looks for cycles twice as it ends: a tenth of a report's time, for memory that goes anyway
        raise
    except BaseException as error:
        if not pressed and not isinstance(error, KeyboardInterrupt):
            raise
        end_now()  # half of an import may be left behind, at which closing in order would stumble


def wake_in(seconds: float) -> None:
    """Have SIGALRM come in a while, in place of one that was to come; never with 0, nor where the system has none."""
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_REAL, seconds)


def end_now() -> NoReturn:
    """End the command as after a Ctrl-C: the book is whole at any moment."""
    with contextlib.suppress(OSError):
        os.set_blocking(2, False)  # a terminal that takes nothing more keeps no command
        os.write(2, f"{_SENTENCE}\n".encode())
    os._exit(INTERRUPTED)


_SENTENCE = "labbook: interrupted; what was finished before is kept, what was not is left out."


def print_interrupted() -> None:
    """Print that the command was interrupted, and what that means for the book."""
    print(_SENTENCE, file=sys.stderr)
