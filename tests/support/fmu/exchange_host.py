"""Host of native plants for model exchange, with FMPy."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy import fmi2, fmi3
from numpy.typing import NDArray

from addin_sdfusion.robot import Robot
from cardsflow_fmu.cosim.signals.continuous import continuous_groups
from cardsflow_fmu.cosim.signals.groups import all_ports
from cardsflow_fmu.cosim.signals.ports import plant_groups
from cardsflow_fmu.models.plant import ContinuousPlantModel, continuous_file
from cardsflow_fmu.runtime.model_file import NativeModel

from .fmu_host import pack

FloatArray = NDArray[np.float64]


def continuous_plant(
    robot: Robot,
    folder: Path,
    q: Sequence[float],
    qd: Sequence[float],
    *,
    energy: bool = False,
    **options: Any,
) -> Path:
    """Write a plant of a robot for model exchange."""
    groups = plant_groups(robot, list(map(float, q)), list(map(float, qd)), 1.0, energy=energy)
    groups = continuous_groups(robot, groups)
    native = NativeModel(continuous_file(robot, groups), True)
    ports = all_ports(groups)
    file, model = folder / "plant.fmu", ContinuousPlantModel
    return pack(file, model, ports, native=native, is_continuous=True, sources=False, **options)


class ExchangeHost:
    """Instance of a plant for model exchange, after initialization and its event.

    Attributes:
        model: FMPy's instance.
        references: Value references by name.
    """

    def __init__(self, file: Path, folder: Path) -> None:
        fmpy.extract(str(file), str(folder))
        description = fmpy.read_model_description(str(folder))
        is_2 = description.fmiVersion == "2.0"
        model: type[Any] = fmi2.FMU2Model if is_2 else fmi3.FMU3Model
        self.is_2 = is_2
        self.references = {v.name: v.valueReference for v in description.modelVariables}
        self.nx = description.numberOfContinuousStates
        self.nz = description.numberOfEventIndicators
        identifier = description.modelExchange.modelIdentifier
        self.model = model(
            guid=description.guid, unzipDirectory=str(folder), modelIdentifier=identifier
        )
        self.start()

    def start(self) -> None:
        """Instantiate, initialize and enter event mode."""
        self.model.instantiate()
        if self.is_2:
            self.model.setupExperiment(startTime=0.0)
        self.model.enterInitializationMode()
        self.model.exitInitializationMode()

    def update(self) -> bool:
        """Handle events in event mode; return whether states changed."""
        found = self.model.newDiscreteStates() if self.is_2 else self.model.updateDiscreteStates()
        assert not found[0]
        assert not found[1]
        assert not found[2]
        assert not found[4]
        return bool(found[3])

    def event(self) -> bool:
        """Handle an event in continuous-time mode; return whether states changed."""
        self.model.enterEventMode()
        changed = self.update()
        self.model.enterContinuousTimeMode()
        return changed

    @property
    def x(self) -> FloatArray:
        """Continuous states."""
        values = np.empty(self.nx)
        self.model.getContinuousStates(_pointer(values), self.nx)
        return values

    @x.setter
    def x(self, values: FloatArray) -> None:
        copy = np.array(values, dtype=np.float64)
        self.model.setContinuousStates(_pointer(copy), self.nx)

    @property
    def dx(self) -> FloatArray:
        """State derivatives."""
        values = np.empty(self.nx)
        get = self.model.getDerivatives if self.is_2 else self.model.getContinuousStateDerivatives
        get(_pointer(values), self.nx)
        return values

    @property
    def z(self) -> FloatArray:
        """Event indicators."""
        values = np.empty(self.nz)
        self.model.getEventIndicators(_pointer(values), self.nz)
        return values

    def get(self, *names: str) -> FloatArray:
        """Return the values of real variables."""
        references = [self.references[name] for name in names]
        get = self.model.getReal if self.is_2 else self.model.getFloat64
        return np.array(get(references))

    def set(self, **values: float) -> None:
        """Set inputs; underscores replace dots of names."""
        names = {name.replace(".", "_"): name for name in self.references}
        references = [self.references[names[name]] for name in values]
        (self.model.setReal if self.is_2 else self.model.setFloat64)(
            references, list(values.values())
        )

    def close(self) -> None:
        self.model.terminate()
        self.model.freeInstance()


@contextmanager
def exchanging(file: Path, folder: Path) -> Iterator[ExchangeHost]:
    """Yield an instance in continuous-time mode."""
    host = ExchangeHost(file, folder)
    host.update()
    host.model.enterContinuousTimeMode()
    yield host
    host.close()


def _pointer(values: FloatArray) -> Any:
    return values.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
