"""FMU host: FMPy with a logger that stores messages, and a plain loop as reference."""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import fmpy
import numpy as np
import pytest
from fmpy import fmi2
from fmpy.fmi1 import FMICallException
from toy_model import PORTS, REFERENCES, ToyModel

from cardsflow_fmu.cosim.signals.port import Port
from cardsflow_fmu.fmu.description import FmiVersion
from cardsflow_fmu.fmu.writer import write_fmu
from cardsflow_fmu.runtime.model import FloatArray, FmuModel

from .fmi3_host import FMU3SlaveAs2

SUPPORT = Path(__file__).parent
"""Folder of the models and hosts of the tests."""
STEP = 1e-3
OUTPUTS = [REFERENCES[name] for name in ("x", "v", "work")]


def environment() -> dict[str, str]:
    """Return environment variables with which other processes import the same modules."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}


class Message(NamedTuple):
    status: int
    category: str
    text: str


@dataclass
class Host:
    """FMU instance with its log messages."""

    slave: fmi2.FMU2Slave
    variables: list[fmpy.model_description.ScalarVariable] = field(default_factory=list)
    messages: list[Message] = field(default_factory=list)
    callbacks: fmi2.fmi2CallbackFunctions = field(default_factory=fmi2.fmi2CallbackFunctions)

    def __post_init__(self) -> None:
        def log(_: object, name: bytes, status: int, category: bytes, text: bytes) -> None:
            assert name == self.slave.instanceName.encode()
            self.messages.append(Message(status, category.decode(), text.decode()))

        self.callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(log)

    @cached_property
    def references(self) -> dict[str, int]:
        """Return value references by name."""
        return {variable.name: variable.valueReference for variable in self.variables}

    def of(self, causality: str) -> list[int]:
        """Return the value references of one causality."""
        return [v.valueReference for v in self.variables if v.causality == causality]

    @property
    def last(self) -> str:
        """Return the last message, formatted like in a host."""
        return self.messages[-1].text.replace("%%", "%").replace("##", "#")

    def open(self, events: bool = False) -> None:
        """Create the instance."""
        self.slave.instantiate(callbacks=self.callbacks, loggingOn=events)

    def instantiate(
        self, guid: str, resources: str, kind: int = fmi2.fmi2CoSimulation, events: bool = False
    ) -> int | None:
        """Call fmi2Instantiate itself."""
        component: int | None = self.slave.fmi2Instantiate(
            self.slave.instanceName.encode(),
            kind,
            guid.encode(),
            resources.encode(),
            ctypes.byref(self.callbacks),
            False,
            events,
        )
        self.slave.component = component
        return component

    def start(self, **parameters: float) -> None:
        """Enter step mode."""
        self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()
        self.set(**parameters)
        self.slave.exitInitializationMode()

    def set(self, **values: float) -> None:
        """Set real variables by name."""
        self.slave.setReal([self.references[name] for name in values], list(values.values()))

    def get(self, *names: str) -> list[float]:
        """Get real variables by name."""
        values: list[float] = self.slave.getReal([self.references[name] for name in names])
        return values

    def value(self, name: str) -> float:
        """Return the value of a real variable."""
        return self.get(name)[0]

    def save(self) -> bytes:
        """Return the serialised state."""
        state = self.slave.getFMUstate()
        data: bytes = self.slave.serializeFMUstate(state)
        self.slave.freeFMUstate(state)
        return data

    def restore(self, data: bytes) -> None:
        """Restore a serialised state."""
        state = self.slave.deSerializeFMUstate(data)
        self.slave.setFMUstate(state)
        self.slave.freeFMUstate(state)

    def drive(self, first: int, last: int) -> FloatArray:
        """Step from `first` to `last` with a varying force; return the outputs after each step."""
        rows = []
        for k in range(first, last):
            self.set(u=force(k))
            self.slave.doStep(k * STEP, STEP)
            rows.append(self.slave.getReal(OUTPUTS))
        return np.array(rows)


@dataclass
class Host3(Host):
    """Instance of an FMI 3.0 FMU with the methods of `Host`."""

    def __post_init__(self) -> None:
        def log(_: object, status: int, category: bytes, text: bytes) -> None:
            self.messages.append(Message(status, category.decode(), text.decode()))

        self.log = log

    @property
    def last(self) -> str:
        return self.messages[-1].text

    def open(self, events: bool = False) -> None:
        self.slave.instantiate(logMessage=self.log, loggingOn=events)


def force(k: int) -> float:
    """Return the force in step k, in [N]."""
    return float(np.sin(0.1 * k))


def plain_run(
    count: int,
    model: ToyModel | None = None,
    u: Callable[[int], float] = force,
    **parameters: float,
) -> FloatArray:
    """Compute the outputs of `Host.start` and `Host.drive` without FMI, for any force."""
    model = model or ToyModel(0.25)
    for name, value in parameters.items():
        model.values[REFERENCES[name]] = value
    model.initialize()
    rows = []
    for k in range(count):
        model.inputs[0] = u(k)
        model.step(k * STEP, STEP)
        rows.append(model.values[OUTPUTS].copy())
    return np.array(rows)


def unpack(
    folder: Path,
    model_class: type[ToyModel] = ToyModel,
    name: str = "toy",
    x_start: float = 0.25,
    fmi: FmiVersion = "2.0",
) -> Path:
    """Build an FMU and unpack it into `folder`; return the folder."""
    resources = {"x_start.txt": repr(x_start).encode()}
    return unpacked(folder, model_class, PORTS, model_name=name, resources=resources, fmi=fmi)


def pack(file: Path, model_class: type[FmuModel], ports: Sequence[Port], **options: Any) -> Path:
    """Build an FMU (default: without resources, with a step of 1 ms)."""
    given = {"model_name": file.stem, "resources": {}, "step": STEP, **options}
    return write_fmu(file, model_class=model_class, ports=ports, **given)


def unpacked(
    folder: Path, model_class: type[FmuModel], ports: Sequence[Port], **options: Any
) -> Path:
    """Build an FMU and unpack it into `folder`; return the folder."""
    file = pack(folder.with_suffix(".fmu"), model_class, ports, **options)
    fmpy.extract(str(file), str(folder))
    return folder


def load(folder: Path, instance_name: str = "größe 1") -> Host:
    """Load an unpacked FMU, without an instance."""
    description = fmpy.read_model_description(str(folder))
    is_2 = description.fmiVersion == "2.0"
    slave = (fmi2.FMU2Slave if is_2 else FMU3SlaveAs2)(
        guid=description.guid,
        unzipDirectory=str(folder),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName=instance_name,
    )
    return (Host if is_2 else Host3)(slave, description.modelVariables)


@contextmanager
def running(file: Path, folder: Path) -> Iterator[Host]:
    """Yield an instance of an FMU in step mode; the FMU is unpacked into a folder."""
    fmpy.extract(str(file), str(folder))
    with opened(folder) as (host,):
        host.start()
        yield host


@contextmanager
def opened(*folders: Path, events: bool = False) -> Iterator[Sequence[Host]]:
    """Yield instances of unpacked FMUs; free them at the end."""
    hosts = [load(folder, f"toy {i}") for i, folder in enumerate(folders)]
    for host in hosts:
        host.open(events)
    yield hosts
    for host in hosts:
        host.slave.freeInstance()


def require_error(call: Callable[[], object]) -> None:
    """Require that a call returns fmi2Error."""
    with pytest.raises(FMICallException) as caught:
        call()
    assert caught.value.status == fmi2.fmi2Error


def cannot_open(folder: Path) -> str:
    """Return the only message of an instantiation that must fail."""
    host = load(folder)
    resources = (folder / "resources").as_uri()
    assert host.instantiate(host.slave.guid, resources) is None
    host.slave.freeLibrary()
    (message,) = host.messages
    assert message.status == fmi2.fmi2Error
    assert message.category == "logStatusError"
    return message.text


def run(command: list[str]) -> str:
    """Run a command that must succeed; return its output."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout
