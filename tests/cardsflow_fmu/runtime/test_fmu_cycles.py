"""Creating and freeing instances leaks no memory, descriptors or processes."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest
from support.cases import sample_cases
from support.fmu.fmu_host import load
from support.fmu.worker_host import children, unpack_stubborn

# Not marked native: the address sanitizer keeps freed memory.
pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="requires /proc")

CYCLES = os.environ.get("CARDSFLOW_TEST_CYCLES")
"""For example 10000, which takes half an hour with workers."""

MAX_GROWTH = 512 * 1024  # bytes, over three quarters of the cycles


@pytest.mark.cases(1)
@pytest.mark.slow
@pytest.mark.parametrize(("mode", "cycles"), sample_cases([("in-process", 1000), ("worker", 16)]))
def test_cycles_leak_no_resources(
    mode: str, cycles: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CARDSFLOW_FMU_HOST", mode)
    cycles = int(CYCLES or cycles)
    folder = unpack_stubborn(tmp_path / "stubborn")
    host = load(folder)
    found = []
    for k in range(cycles):
        assert host.instantiate(host.slave.guid, (folder / "resources").as_uri())
        host.slave.fmi2FreeInstance(host.slave.component)
        if k in (cycles // 4, cycles - 1):
            found.append((descriptors(), children(), resident_bytes()))
    host.slave.freeLibrary()
    (files, processes, size), (files_later, processes_later, size_later) = found
    assert files_later == files
    assert processes_later == processes
    assert size_later - size <= MAX_GROWTH


def descriptors() -> list[str]:
    """Return the open file descriptors."""
    return sorted(os.listdir("/proc/self/fd"))  # noqa: PTH208


def resident_bytes() -> int:
    pages = int(Path("/proc/self/statm").read_text("utf-8").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")
