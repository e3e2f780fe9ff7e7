"""Dependencies of the outputs of FMUs: declared, and observed by changes of each variable."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException
from numpy.typing import NDArray

from .fmu_host import Host, load

FloatArray = NDArray[np.float64]
Table = dict[str, frozenset[str]]

SHORT = 1e-5
"""Step for the test whether a tenth of the step causes a tenth of the change, in [s]."""
SIZES = {"": 0.2, "N": 5.0, "N.m": 0.5, "Pa": 2e4, "V": 2.0, "m": 0.02, "rad": 0.05, "s": 1e-6}
SEEN = 1e-7
"""Minimum observed change of an output, relative to 1 + |value|."""


def declared(file: Path, *, at_start: bool) -> Table:
    """Return the declared dependencies of a model description, by output."""
    description = fmpy.read_model_description(str(file))
    unknowns = description.initialUnknowns if at_start else description.outputs
    found = {}
    for unknown in unknowns:
        assert unknown.dependencies is not None, unknown.variable.name
        found[unknown.variable.name] = frozenset(known.name for known in unknown.dependencies)
    return found


class RefusedError(Exception):
    """A call returned an error."""


class Probe:
    """Instance that is restarted for every experiment."""

    def __init__(self, file: Path, folder: Path, base: Mapping[str, float]) -> None:
        fmpy.extract(str(file), str(folder))
        self.host: Host = load(folder)
        self.host.open()
        self.base = dict(base)
        self._variables = {v.name: v for v in self.host.variables if v.causality != "independent"}

    def close(self) -> None:
        self.host.slave.freeInstance()

    def names(self, *causalities: str) -> list[str]:
        return [name for name, v in self._variables.items() if v.causality in causalities]

    def size(self, name: str) -> float:
        """Return a change of a variable that has an effect and is valid."""
        variable = self._variables[name]
        return SIZES.get(variable.unit or "", 0.1) + 0.1 * abs(self.start(name))

    def start(self, name: str) -> float:
        return self.base.get(name, float(self._variables[name].start or 0.0))

    def answered(self, call: Callable[[], object]) -> None:
        """Raise an error with the message of the FMU if a call failed."""
        try:
            call()
        except FMICallException:
            raise RefusedError(self.host.last) from None

    def outputs(self) -> FloatArray:
        values = []
        for name in self.names("output"):
            variable = self._variables[name]
            is_real = variable.type in ("Real", "Float64")
            get = self.host.slave.getReal if is_real else self.host.slave.getBoolean
            values.append(float(get([variable.valueReference])[0]))
        return np.array(values)

    def at_start(self, **changed: float) -> FloatArray:
        self._begin(changed)
        self.answered(lambda: self.host.get(self.names("output")[0]))
        return self.outputs()

    def behind(self, step: float, **changed: float) -> FloatArray:
        """Return the outputs after a second step with changed variables."""
        self._begin({"step": step} if "step" in self._variables else {})
        self.answered(self.host.slave.exitInitializationMode)
        self.answered(lambda: self.host.slave.doStep(0.0, step))
        self.answered(lambda: self.host.set(**changed))
        self.answered(lambda: self.host.slave.doStep(step, step))
        return self.outputs()

    def _begin(self, changed: Mapping[str, float]) -> None:
        self.host.slave.reset()
        self.host.slave.setupExperiment(startTime=0.0)
        self.host.slave.enterInitializationMode()
        self.answered(lambda: self.host.set(**self.base | changed))


def _moved(probe: Probe, of: Callable[..., FloatArray], name: str, scale: float) -> FloatArray:
    """Return the change of each output by a variable, relative to 1 + |value at the start|.

    One of the two signs may result in a value that the model rejects.
    """
    at, size = of(), 1.0 + np.abs(probe.at_start())
    moved = []
    for sign in (1.0, -1.0):
        value = probe.start(name) + sign * scale * probe.size(name)
        with suppress(RefusedError):
            moved.append(np.abs(of(**{name: value}) - at) / size)
    assert moved, name
    far: FloatArray = np.max(moved, axis=0)
    return far


def _table(probe: Probe, columns: Mapping[str, NDArray[np.bool_]]) -> Table:
    names = probe.names("output")
    return {
        name: frozenset(known for known, seen in columns.items() if seen[k])
        for k, name in enumerate(names)
    }


def observed_at_start(probe: Probe, knowns: Iterable[str]) -> Table:
    return _table(probe, {k: _moved(probe, probe.at_start, k, 1.0) > SEEN for k in knowns})


def observed_direct(probe: Probe) -> Table:
    """Return the observed direct dependencies of a model with variable steps.

    A direct dependency causes the same change in a step of a tenth of the length.
    """
    columns = {}
    for name in probe.names("input"):
        far, near = (
            _moved(probe, lambda h=h, **more: probe.behind(h, **more), name, 1.0)
            for h in (SHORT, SHORT / 10)
        )
        columns[name] = (near > SEEN) & (near > 0.5 * far)
    return _table(probe, columns)


def observed_at_tick(
    probe: Probe, period: float, knowns: Iterable[str], scales: Iterable[float]
) -> Table:
    """Return the observed dependencies of a sampled model at a tick, for several changes."""
    columns = {}
    for name in knowns:
        moved = [
            _moved(probe, lambda **more: probe.behind(period, **more), name, scale) > SEEN
            for scale in scales
        ]
        columns[name] = np.any(moved, axis=0)
    return _table(probe, columns)


def unobserved(declared: Table, seen: Table) -> dict[str, frozenset[str]]:
    """Return declared dependencies that are not observed, except for directions without motion.

    A planar robot does not move along the axes of its joints: a load along them has no effect, and
    no coordinate changes the momentum along them.
    """
    acting = frozenset().union(*seen.values())
    found = {
        name: (knowns & acting) - seen[name] for name, knowns in declared.items() if seen[name]
    }
    return {name: knowns for name, knowns in found.items() if knowns}


def undeclared(declared: Table, seen: Table) -> dict[str, frozenset[str]]:
    """Return observed dependencies that are not declared."""
    found = {name: seen[name] - knowns for name, knowns in declared.items()}
    return {name: knowns for name, knowns in found.items() if knowns}
