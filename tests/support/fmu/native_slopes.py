"""Derivatives of native plants: through FMI 2.0, and by differences of high order."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import fmpy
import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import Robot
from cardsflow_fmu.cosim.signals.groups import all_ports
from cardsflow_fmu.cosim.signals.muscles import driven_muscles, ideal_muscles, state_order
from cardsflow_fmu.cosim.signals.ports import plant_groups
from cardsflow_fmu.models.native.fields import encode
from cardsflow_fmu.models.plant import PlantModel, plant_fields
from cardsflow_fmu.runtime.model_file import NativeModel
from sim_dart import compile_blob

from .fmu_host import load, pack

FloatArray = NDArray[np.float64]
STEP = 1e-3
EIGHTH = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
"""Weights of the central difference of order eight."""

Gamma = Callable[[FloatArray], FloatArray]


def stretched(gamma: Gamma, at: FloatArray, direction: FloatArray, size: float) -> FloatArray:
    """Return the derivative of gamma along a direction; the error has order size**8.

    Angles may wrap around.
    """
    slope = np.zeros_like(gamma(at))
    for k, weight in EIGHTH.items():
        change = gamma(at + k * size * direction) - gamma(at - k * size * direction)
        slope += weight * (change - 2 * np.pi * np.round(change / (2 * np.pi)))
    return slope / size


class Slave:
    """Native plant through FMI 2.0, with arrays as arguments and results."""

    def __init__(self, file: Path, folder: Path) -> None:
        fmpy.extract(str(file), str(folder))
        description = fmpy.read_model_description(str(folder))
        assert description.coSimulation.providesDirectionalDerivative
        host = load(folder)
        host.open()
        self.slave = host.slave
        self.names = list(host.references)
        self.of = {kind: host.of(kind) for kind in ("input", "output", "parameter")}
        self.settle()

    def settle(self, references: Sequence[int] = (), values: Sequence[float] = ()) -> None:
        """Enter initialization mode with inputs and start values."""
        self.slave.reset()
        self.slave.setupExperiment(startTime=0.0)
        self.slave.setReal(list(references), list(values))
        self.slave.enterInitializationMode()
        self.time = 0.0

    def restart(self, references: Sequence[int] = (), values: Sequence[float] = ()) -> None:
        """Restart, and enter step mode with inputs and start values."""
        self.settle(references, values)
        self.slave.exitInitializationMode()

    def references(self, *prefixes: str) -> list[int]:
        """Return the references of the variables with a prefix before the dot, in their order."""
        return [k for k, name in enumerate(self.names) if name.split(".")[0] in prefixes]

    def step(self, steps: int = 1) -> FloatArray:
        self.slave.doStep(self.time, steps * STEP)
        self.time += steps * STEP
        return np.array(self.slave.getReal(self.of["output"]))

    def derivative(self, knowns: list[int], seeds: FloatArray) -> FloatArray:
        outputs = self.of["output"]
        return np.array(self.slave.getDirectionalDerivative(outputs, knowns, list(seeds)))


class Options(NamedTuple):
    """Options of a plant: its step and additional features."""

    substeps: int = 1
    integrator: str = "euler"
    energy: bool = False
    wrenches: tuple[str, ...] = ()


PLAIN = Options()


def plant_file(
    robot: Robot, folder: Path, q: FloatArray, qd: FloatArray, options: Options = PLAIN
) -> Path:
    """Write a native plant of a robot with a given start state."""
    substeps, integrator, energy, wrenches = options
    groups = plant_groups(robot, q.tolist(), qd.tolist(), STEP, energy=energy, wrenches=wrenches)
    fields = plant_fields(robot, substeps, integrator, wrenches)
    contents = encode("plant", compile_blob(robot), groups, *fields)
    native = NativeModel(contents, True)
    return pack(folder / "plant.fmu", PlantModel, all_ports(groups), native=native)


@contextmanager
def started(
    robot: Robot, folder: Path, q: FloatArray, qd: FloatArray, options: Options = PLAIN
) -> Iterator[Slave]:
    slave = Slave(plant_file(robot, folder, q, qd, options), folder / "unpacked")
    slave.restart()
    yield slave
    slave.slave.terminate()
    slave.slave.freeInstance()


def gamma_of(slave: Slave, knowns: list[int]) -> Gamma:
    """Return the outputs after a step as a function of inputs and start state."""
    start = [slave.names.index(_start_of(slave.names[k])) for k in knowns]

    def gamma(values: FloatArray) -> FloatArray:
        slave.restart(start, values)
        return slave.step()

    return gamma


def _start_of(name: str) -> str:
    head, _, tail = name.partition(".")
    return f"{head}_start.{tail}" if head in ("q", "qd") else name


def slave_at(slave: Slave, inputs: list[int], at: FloatArray) -> Slave:
    slave.restart()
    slave.slave.setReal(inputs, list(at[: len(inputs)]))
    return slave


def check(
    robot: Robot,
    folder: Path,
    q: FloatArray,
    qd: FloatArray,
    commands: FloatArray,
    *,
    seed: int = 0,
    substeps: int = 1,
    size: float = 2e-4,
    tolerance: float = 1e-8,
) -> None:
    """Check derivatives at the start and after a step, along random directions.

    Inputs and start values determine the initial states of muscles. Therefore the derivatives of
    a step are with respect to all of its initial values, along the derivatives at the start. They
    are compared if differences of two sizes agree, which is nearly always the case. Errors are
    relative to the largest change of a kind of outputs.
    """
    rng = np.random.default_rng(seed)
    n, states = len(robot.coordinates), len(state_order(robot))
    with started(robot, folder, q, qd, Options(substeps)) as slave:
        inputs, outputs = slave.of["input"], slave.of["output"]
        starts = [*inputs, *slave.references("q_start"), *slave.references("qd_start")]
        begins = [*inputs, *outputs[: 2 * n], *outputs[len(outputs) - states :]]
        loads = rng.uniform(-9, 9, len(inputs) - commands.size)
        at = np.concatenate([commands, loads, q, qd])
        spread = np.concatenate([np.abs(commands) + 1e-2, np.ones(at.size - commands.size)])

        def gamma(values: FloatArray) -> FloatArray:
            slave.restart(starts, values)
            first = np.array(slave.slave.getReal(outputs))
            return np.concatenate([first, slave.step()])

        judged = []
        for _ in range(3):
            direction = rng.uniform(-1, 1, at.size) * spread
            slave.settle(starts, at)
            first = slave.derivative(starts, direction)
            slave.slave.exitInitializationMode()
            ahead = [direction[: len(inputs)], first[: 2 * n], first[first.size - states :]]
            found = np.concatenate([first, slave.derivative(begins, np.concatenate(ahead))])
            assert np.isfinite(found).all()
            expected, again = (stretched(gamma, at, direction, size / k) for k in (1, 2))
            scale = scales(robot, np.abs(expected))
            sure = np.abs(expected - again) <= tolerance * scale
            judged.append(sure)
            assert (np.abs(found - again) <= 3 * tolerance * scale)[sure].all()
        assert np.mean(judged) > 0.95


def scales(robot: Robot, changes: FloatArray) -> FloatArray:
    """Return the largest change of the kind of each output, twice."""
    n, m, states = len(robot.coordinates), len(robot.muscles), len(state_order(robot))
    half = changes.size // 2
    kinds = [n, 2 * n, 2 * n + m]
    if states:
        kinds.append(half - states)
    largest = []
    for one in np.split(changes, 2):
        for kind in np.split(one, kinds):
            largest.append(np.full(kind.size, max(kind.max(initial=0.0), 1e-9)))
    return np.concatenate(largest)


def count_commands(robot: Robot) -> int:
    """Return the number of muscles with commands."""
    return len(ideal_muscles(robot)) + len(driven_muscles(robot))
