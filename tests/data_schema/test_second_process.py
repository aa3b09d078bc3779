import os
import signal
import sys
import time
from collections.abc import Callable

import pytest

from data_schema.second_process import run_in_fork

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="there is no second process here")


def test_a_second_process_gives_what_its_work_returned() -> None:
    text = "x" * 1_000_000
    copies = [run_in_fork(lambda: (os.getpid(), text)) for _ in range(2)]
    processes = []
    for copy in copies:
        found = copy.result()
        assert found is not None
        processes.append(found[0])
        assert found[1] == text
    assert len({os.getpid(), *processes}) == 3


def _fails() -> None:
    raise RuntimeError("the work fails")


def _is_killed() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.parametrize("work", [_fails, _is_killed, lambda: lambda: None], ids=["fails", "is killed", "unpicklable"])
def test_work_without_an_end_gives_nothing(work: Callable[[], object], capfd: pytest.CaptureFixture[str]) -> None:
    assert run_in_fork(work).result() is None
    assert capfd.readouterr() == ("", "")


def test_work_that_is_not_wanted_ends() -> None:
    copy = run_in_fork(lambda: time.sleep(3600))
    copy.stop()
    copy.stop()
    with pytest.raises(ProcessLookupError):
        os.kill(copy.process, 0)
    done = run_in_fork(lambda: 1)
    assert done.result() == 1
    done.stop()
