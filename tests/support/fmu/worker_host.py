"""FMUs of the stubborn model, and a host in a separate process."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from stubborn_model import PORTS, StubbornModel

from .fmu_host import STEP, Host, opened, unpacked


def unpack_stubborn(folder: Path) -> Path:
    """Build an FMU of the stubborn model and unpack it into `folder`; return the folder."""
    return unpacked(folder, StubbornModel, PORTS, resources={"factor.txt": b"1.0"})


@contextmanager
def opened_stubborn(folder: Path) -> Iterator[Host]:
    """Yield an instance in step mode; free it at the end."""
    with opened(folder) as (host,):
        host.start()
        yield host


def sums(host: Host, first: int, last: int) -> list[float]:
    """Step from `first` to `last` with u = k; return the sum after each step."""
    found = []
    for k in range(first, last):
        host.set(u=float(k))
        host.slave.doStep(k * STEP, STEP)
        found += host.get("sum")
    return found


def is_running(process: float) -> bool:
    """Return whether a process is running; Linux only."""
    try:
        text = Path(f"/proc/{int(process)}/stat").read_text("utf-8")
    except OSError:
        return False
    return text.rpartition(")")[2].split()[0] != "Z"


def children(process: int | str = "self") -> list[int]:
    """Return the numbers of the child processes of a process, running or not; Linux only."""
    found: list[int] = []
    for task in Path(f"/proc/{process}/task").iterdir():
        found += map(int, (task / "children").read_text("utf-8").split())
    return found
