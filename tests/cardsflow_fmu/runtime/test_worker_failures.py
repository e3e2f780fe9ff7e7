"""Worker processes that die, hang or lose their host do not affect the host."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from stubborn_model import CRASH, EXIT, HOLD, SLEEP, WELL
from support.fmu.fmu_host import STEP, environment, require_error
from support.fmu.worker_host import (
    children,
    is_running,
    opened_stubborn,
    sums,
)
from support.process_output import wait_until

pytestmark = [
    pytest.mark.native,
    pytest.mark.skipif(sys.platform != "linux", reason="requires /proc"),
]

KILLS = int(os.environ.get("CARDSFLOW_TEST_KILLS", "3"))

HOST = """
import sys
from pathlib import Path
from support.fmu.fmu_host import load
host = load(Path(sys.argv[1]))
host.open()
host.start()
print(int(host.value("process")), flush=True)
host.set(action=float(sys.argv[2]))
if sys.argv[2] != "0":
    host.slave.doStep(0.0, 1e-3)
sys.stdin.read()
"""


@pytest.fixture(autouse=True)
def worker(monkeypatch: pytest.MonkeyPatch) -> None:
    """Run models in worker processes."""
    monkeypatch.setenv("CARDSFLOW_FMU_HOST", "worker")


@pytest.mark.slow
def test_worker_killed_within_a_step_is_reported(stubborn_fmu: Path) -> None:
    with opened_stubborn(stubborn_fmu) as host:
        expected = sums(host, 0, 5)
        for _ in range(KILLS):
            process = int(host.value("process"))
            host.set(action=SLEEP, worker_timeout=1e6)
            killer = threading.Timer(0.05, os.kill, (process, signal.SIGKILL))
            killer.start()
            require_error(lambda: host.slave.doStep(5 * STEP, STEP))
            killer.join()
            assert host.last.endswith("the worker process was ended by signal 9")
            require_error(lambda: host.value("sum"))
            host.slave.reset()
            host.start()
            assert host.value("process") != process
            assert sums(host, 0, 5) == expected


@pytest.mark.slow
def test_worker_killed_between_steps_is_reported(stubborn_fmu: Path) -> None:
    with opened_stubborn(stubborn_fmu) as host:
        for call in ("doStep", "reset"):
            os.kill(int(host.value("process")), signal.SIGKILL)
            if call == "doStep":
                require_error(lambda: host.slave.doStep(0.0, STEP))
            host.slave.reset()
            host.start()
        assert sums(host, 0, 3) == [0.0, 1.0, 3.0]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("action", "message"),
    [(EXIT, "the worker process has ended with exit code 7"), (CRASH, "the worker process ")],
)
def test_worker_that_exits_is_reported(stubborn_fmu: Path, action: int, message: str) -> None:
    with opened_stubborn(stubborn_fmu) as host:
        host.set(action=action)
        require_error(lambda: host.slave.doStep(0.0, STEP))
        assert message in host.last
        host.slave.reset()
        host.start()
        assert sums(host, 0, 3) == [0.0, 1.0, 3.0]


@pytest.mark.slow
@pytest.mark.parametrize("action", [SLEEP, HOLD])
@pytest.mark.parametrize("told_by", ["environment", "parameter"])
def test_hanging_worker_is_ended(
    stubborn_fmu: Path, action: int, told_by: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    timeout = 0.5
    if told_by == "environment":
        timeout = 4.0  # of all calls: of those of a busy machine too
        monkeypatch.setenv("CARDSFLOW_FMU_TIMEOUT", f"{timeout:g}")
    with opened_stubborn(stubborn_fmu) as host:
        process = host.value("process")
        host.set(action=action, worker_timeout=timeout if told_by == "parameter" else 1e6)
        begin = time.monotonic()
        require_error(lambda: host.slave.doStep(0.0, STEP))
        assert time.monotonic() - begin > 0.8 * timeout
        assert host.last.endswith(f"no answer from the worker process within {timeout:g} s")
        assert not is_running(process)
        host.slave.reset()
        host.start()
        assert sums(host, 0, 3) == [0.0, 1.0, 3.0]


@pytest.mark.slow
def test_state_restores_a_dead_worker(stubborn_fmu: Path) -> None:
    with opened_stubborn(stubborn_fmu) as host:
        state = host.slave.getFMUstate()
        os.kill(int(host.value("process")), signal.SIGKILL)
        require_error(lambda: host.slave.doStep(0.0, STEP))
        host.slave.setFMUstate(state)
        host.slave.freeFMUstate(state)
        host.set(u=1.0)
        host.slave.doStep(0.0, STEP)


@pytest.mark.slow
@pytest.mark.parametrize("action", [WELL, SLEEP, HOLD])
def test_worker_ends_with_a_killed_host(stubborn_fmu: Path, action: int) -> None:
    with separate_host(stubborn_fmu, action) as host:
        process = read_number(host)
        assert is_running(process)
        time.sleep(0.1)
        host.kill()
    assert wait_until(lambda: not is_running(process))


@pytest.mark.slow
def test_worker_ends_with_its_host(stubborn_fmu: Path) -> None:
    with separate_host(stubborn_fmu, WELL) as host:
        process = read_number(host)
        host.communicate("")
    assert wait_until(lambda: not is_running(process))


@pytest.mark.slow
def test_interrupt_of_the_terminal_is_ignored(stubborn_fmu: Path) -> None:
    with opened_stubborn(stubborn_fmu) as host:
        os.kill(int(host.value("process")), signal.SIGINT)
        assert sums(host, 0, 3) == [0.0, 1.0, 3.0]
        assert os.getpgid(int(host.value("process"))) != os.getpgid(0)


def test_host_that_ignores_its_children_is_supported(stubborn_fmu: Path) -> None:
    before = signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    try:
        with opened_stubborn(stubborn_fmu) as host:
            assert sums(host, 0, 3) == [0.0, 1.0, 3.0]
            os.kill(int(host.value("process")), signal.SIGKILL)
            require_error(lambda: host.slave.doStep(3 * STEP, STEP))
    finally:
        signal.signal(signal.SIGCHLD, before)


@pytest.mark.slow
def test_free_releases_all_resources(stubborn_fmu: Path) -> None:
    with opened_stubborn(stubborn_fmu) as host:
        process = host.value("process")
        assert int(process) in children()
    assert int(process) not in children()


def separate_host(fmu: Path, action: int) -> subprocess.Popen[str]:
    """Start a separate host process that prints the ID of its worker and waits."""
    return subprocess.Popen(
        [sys.executable, "-c", HOST, str(fmu), str(action)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=environment(),
    )


def read_number(host: subprocess.Popen[str]) -> int:
    assert host.stdout is not None
    return int(host.stdout.readline())


CLOSED = """
import os, sys
from pathlib import Path
from support.fmu.fmu_host import load
from support.fmu.worker_host import sums
output = os.dup(1)
for number in map(int, sys.argv[2]):
    os.close(number)
host = load(Path(sys.argv[1]))
host.open()
host.start()
os.write(output, repr(sums(host, 0, 5)).encode())
host.slave.freeInstance()
"""


@pytest.mark.cases(1)
@pytest.mark.slow
@pytest.mark.parametrize("closed", ["2", "01", "012"])
def test_host_without_standard_files_is_supported(stubborn_fmu: Path, closed: str) -> None:
    with opened_stubborn(stubborn_fmu) as host:
        expected = sums(host, 0, 5)
    command = [sys.executable, "-c", CLOSED, str(stubborn_fmu), closed]
    done = subprocess.run(command, env=environment(), stdout=subprocess.PIPE, check=False)
    assert done.stdout.decode() == repr(expected)
