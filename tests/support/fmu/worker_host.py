"""FMUs of the stubborn model, and a host of them in a process of its own."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import fmpy
from stubborn_model import PORTS, REFERENCES, StubbornModel

from cardsflow_fmu.fmu.writer import write_fmu

from .fmu_host import STEP, Host, load


def unpack_stubborn(folder: Path, factor: float = 1.0, name: str = "stubborn") -> Path:
    """Build an FMU of the stubborn model and unpack it into `folder`; returns that."""
    archive = write_fmu(
        folder.with_suffix(".fmu"),
        model_class=StubbornModel,
        model_name=name,
        ports=PORTS,
        resources={"factor.txt": repr(factor).encode()},
        step=STEP,
    )
    fmpy.extract(str(archive), str(folder))
    return folder


@contextmanager
def opened_stubborn(folder: Path) -> Iterator[Host]:
    """An instance in step mode, freed at the end."""
    host = load(folder, "stubborn")
    host.slave.instantiate(callbacks=host.callbacks)
    start(host)
    yield host
    host.slave.freeInstance()


def start(host: Host) -> None:
    """Everything up to step mode."""
    host.slave.setupExperiment(startTime=0.0)
    host.slave.enterInitializationMode()
    host.slave.exitInitializationMode()


def put(host: Host, **values: float) -> None:
    """Set variables by name."""
    host.slave.setReal([REFERENCES[name] for name in values], list(values.values()))


def value(host: Host, name: str) -> float:
    """A variable by name."""
    (found,) = host.slave.getReal([REFERENCES[name]])
    return float(found)


def sums(host: Host, first: int, last: int) -> list[float]:
    """Step from `first` to `last` with u = k; the sums behind every step."""
    found = []
    for k in range(first, last):
        put(host, u=float(k))
        host.slave.doStep(k * STEP, STEP)
        found.append(value(host, "sum"))
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


def eventually(holds: Callable[[], bool], seconds: float = 100.0) -> bool:
    """Whether something comes true within some seconds."""
    end = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > end:
            return False
        time.sleep(0.01)
    return True
