"""A host that forks: calls of its copy do not affect the instance."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Callable
from pathlib import Path

import pytest
from support.fmu.fmu_host import STEP, Host, require_error
from support.fmu.worker_host import is_running, opened_stubborn, sums

pytestmark = [
    pytest.mark.native,
    pytest.mark.skipif(sys.platform != "linux", reason="requires /proc"),
    pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning"),
]


def run_in_copy(action: Callable[[], object]) -> None:
    """Run a function in a forked copy of this process, which ends without clean-up."""
    copy = os.fork()
    if copy == 0:
        code = 1
        try:
            action()
            code = 0
        except BaseException:
            traceback.print_exc()
        finally:
            os._exit(code)
    assert os.waitstatus_to_exitcode(os.waitpid(copy, 0)[1]) == 0


def check(host: Host, action: Callable[[], object]) -> None:
    """Check that the instance continues unchanged, in the same process."""
    first, process = sums(host, 0, 3), host.value("process")
    run_in_copy(action)
    assert host.value("process") == process
    assert is_running(process)
    again = sums(host, 3, 6)
    host.slave.reset()
    host.start()
    assert sums(host, 0, 6) == first + again


@pytest.mark.parametrize("where", ["worker", "in-process"])
def test_forked_copy_frees_the_instance(
    where: str, stubborn_fmu: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CARDSFLOW_FMU_HOST", where)
    with opened_stubborn(stubborn_fmu) as host:
        check(host, host.slave.freeInstance)


@pytest.mark.slow
def test_forked_copy_calls_the_instance(
    stubborn_fmu: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CARDSFLOW_FMU_HOST", "worker")
    with opened_stubborn(stubborn_fmu) as host:

        def call() -> None:
            require_error(lambda: host.slave.doStep(3 * STEP, STEP))
            assert "belongs to the process that this one was forked from" in host.last
            require_error(host.slave.reset)
            host.slave.freeInstance()

        check(host, call)
