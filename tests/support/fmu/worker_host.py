"""FMUs of the stubborn model, and a host of them in a process of its own."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from stubborn_model import PORTS, StubbornModel

from .fmu_host import STEP, Host, opened, unpacked


def unpack_stubborn(folder: Path) -> Path:
    """Build an FMU of the stubborn model and unpack it into `folder`; returns that."""
    return unpacked(folder, StubbornModel, PORTS, resources={"factor.txt": b"1.0"})


@contextmanager
def opened_stubborn(folder: Path) -> Iterator[Host]:
    """An instance in step mode, freed at the end."""
    with opened(folder) as (host,):
        host.start()
        yield host


def sums(host: Host, first: int, last: int) -> list[float]:
    """Step from `first` to `last` with u = k; the sums behind every step."""
    found = []
    for k in range(first, last):
        host.set(u=float(k))
        host.slave.doStep(k * STEP, STEP)
        found += host.get("sum")
    return found


def is_running(process: float) -> bool:
    """Whether a process is there that has not ended; Linux only."""
    try:
        text = Path(f"/proc/{int(process)}/stat").read_text("utf-8")
    except OSError:
        return False
    return text.rpartition(")")[2].split()[0] != "Z"


def children(process: int | str = "self") -> list[int]:
    """Numbers of the processes that a process has started, ended or not; Linux only."""
    found: list[int] = []
    for task in Path(f"/proc/{process}/task").iterdir():
        found += map(int, (task / "children").read_text("utf-8").split())
    return found
