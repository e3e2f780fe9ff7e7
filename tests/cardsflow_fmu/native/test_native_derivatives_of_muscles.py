"""Directional derivatives of native plants with wrapped muscles and with muscle laws."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import fmpy
import numpy as np
import pytest
from support.cases import sample_cases
from support.fmu.fmu_host import running
from support.fmu.native_slopes import FloatArray, check, count_commands, started
from support.robots.muscle_bench import SOUND
from support.robots.random_robots import random_robot, random_tree
from support.robots.robots import EXAMPLES, stopped
from support.robots.wrapped import FAR, carriage, sequences, single_wraps, wrapped_tree

from addin_sdfusion.robot import (
    WORLD,
    CableModel,
    Muscle,
    Pose,
    Robot,
    ViaPoint,
    Wrap,
    WrapSurface,
)
from cardsflow_fmu import Experiment
from cardsflow_fmu.simulation.build import build
from sim_dart import CoreDynamics

PULL = 5e3
"""Pull in [N]: large, so that changes of moment arms with q are significant."""


def inside(robot: Robot) -> Robot:
    """Return the robot with each muscle inside its surfaces."""
    turned = [
        replace(m, wraps=tuple(replace(w, side=0, turns=0, inside=True) for w in m.wraps))
        for m in robot.muscles
    ]
    return robot.with_muscles(turned)


PATHS: dict[str, Any] = {
    "either side": lambda rng: single_wraps(rng, 8, sides=(-1, 0, 1)),
    "turns": lambda rng: single_wraps(rng, 8, sides=(-1, 0, 1), turns=(1, 2)),
    "ends of cylinders": lambda rng: single_wraps(rng, 8, lengths=(0.2, 0.4)),
    "inside": lambda rng: inside(single_wraps(rng, 8)),
    "two surfaces": lambda rng: sequences(rng, 4, 2),
    "three surfaces, chosen sides": lambda rng: sequences(rng, 4, 3, sides=(-1, 0, 1)),
    "four surfaces": lambda rng: sequences(rng, 3, 4),
    "inside three": lambda rng: inside(sequences(rng, 4, 3)),
    "pulley": lambda rng: sequences(rng, 4, 0, pulley=True),
    "pulley and surface": lambda rng: sequences(rng, 4, 1, pulley=True),
    "pulley and two surfaces": lambda rng: sequences(rng, 4, 2, pulley=True),
    "a tree": lambda rng: wrapped_tree(random_tree(3, 0.1), 3),
}


@pytest.mark.cases(8)
@pytest.mark.slow
@pytest.mark.parametrize("name", PATHS)
def test_paths(name: str, tmp_path: Path) -> None:
    rng = np.random.default_rng(sorted(PATHS).index(name))
    robot: Robot = PATHS[name](rng)
    n, m = len(robot.coordinates), len(robot.muscles)
    q, qd = rng.uniform(-0.2, 0.2, n), rng.uniform(-0.3, 0.3, n)
    check(robot, tmp_path, q, qd, rng.uniform(0.1, 1, m) * PULL, size=1e-5)


def with_law(robot: Robot, kind: str, extra: dict[str, float]) -> Robot:
    """Return the robot with a law for every muscle, scaled to its length at q = 0."""
    lengths = CoreDynamics(robot).muscle_lengths(np.zeros(len(robot.coordinates)))
    muscles = []
    for muscle, length in zip(robot.muscles, map(float, lengths), strict=True):
        hill = {"optimal_fibre_length": 0.3 * length, "tendon_slack_length": 0.7 * length}
        parameters = SOUND[kind] | extra | (hill if kind.startswith("hill") else {})
        if kind == "heavy_cable":
            muscle = replace(muscle, via_points=(muscle.via_points[0], muscle.via_points[-1]))
        muscles.append(replace(muscle, model=CableModel(kind, tuple(parameters.items()))))  # type: ignore[arg-type]
    return robot.with_muscles(muscles)


LAWS = [(kind, {}) for kind in SOUND] + [
    (kind, {"elastic_tendon": 1.0}) for kind in SOUND if kind.startswith("hill")
]


@pytest.mark.cases(8)
@pytest.mark.slow
@pytest.mark.parametrize("seed", sample_cases(range(2)))
@pytest.mark.parametrize(("kind", "extra"), LAWS)
def test_laws(kind: str, extra: dict[str, float], seed: int, tmp_path: Path) -> None:
    """Tensions and states as outputs, states also as knowns."""
    rng = np.random.default_rng(seed)
    robot = with_law(random_robot(seed), kind, extra)
    n = len(robot.coordinates)
    q, qd = rng.uniform(-0.1, 0.1, n), rng.uniform(-0.1, 0.1, n)
    commands = rng.uniform(0.2, 0.8, count_commands(robot))
    stiff = {"series_elastic_motor": 8e-5, "winch": 8e-5, "winch_position": 6e-4}
    size = stiff.get(kind, 8e-6)  # rounding errors limit smaller sizes
    check(robot, tmp_path, q, qd, commands, substeps=2, size=size, tolerance=1e-8)


def test_laws_over_wraps_at_a_limit(tmp_path: Path) -> None:
    """Combination with a joint that hits its stop within the step."""
    rng = np.random.default_rng(5)
    robot = wrapped_tree(random_robot(5), 5)
    robot = with_law(robot, "hill_millard2012", {"elastic_tendon": 1.0})
    n = len(robot.coordinates)
    q, qd = rng.uniform(-0.1, 0.1, n), rng.uniform(-0.1, 0.1, n)
    qd[0] = 3.0
    robot = stopped(robot, float(q[0]) + 1e-3)
    check(
        robot,
        tmp_path,
        q,
        qd,
        rng.uniform(0.2, 0.8, count_commands(robot)),
        size=8e-6,
        tolerance=1e-8,
    )


@pytest.mark.slow
@pytest.mark.parametrize("example", ["pneumatic_elbow", "hill_arm"])
def test_examples_declare_directional_derivatives(example: str, tmp_path: Path) -> None:
    experiment = Experiment.load(EXAMPLES / example, {"plant.energy": False})
    files = build(experiment, tmp_path, compute="c")
    for name, file in files.items():
        description = fmpy.read_model_description(str(file))
        has = description.coSimulation.providesDirectionalDerivative
        assert has == (name == "plant")


# ------------------------------------------------------------------------------------------- kinks


def derivatives(robot: Robot, folder: Path, q: FloatArray, commands: FloatArray) -> FloatArray:
    """Return derivatives of all outputs after a step, one column for each known."""
    with started(robot, folder, q, np.zeros(q.size)) as slave:
        inputs = slave.of["input"]
        slave.slave.setReal(inputs[: commands.size], list(commands))
        knowns = [*inputs, *slave.references("q"), *slave.references("qd")]
        return np.array([slave.derivative([k], np.ones(1)) for k in knowns]).T


Vector = tuple[float, float, float]


def over(surface: WrapSurface, begin: Vector, end: Vector, side: Literal[0, 1]) -> Robot:
    """Return a muscle from the world to a carriage, over one surface."""
    ends = (ViaPoint(WORLD, begin), ViaPoint(FAR, end))
    return carriage([Muscle("m", ends, wraps=(Wrap("ring", 0, side),))], [surface])


def straight(begin: Vector, end: Vector) -> Robot:
    """Return the same muscle without a surface."""
    return carriage([Muscle("m", (ViaPoint(WORLD, begin), ViaPoint(FAR, end)))], [])


BALL = WrapSurface("ring", WORLD, "sphere", 0.25, Pose((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
ROLL = replace(BALL, shape="cylinder")
TIGHT = np.array([100.0])
KINKS: dict[str, tuple[Robot, FloatArray]] = {
    "no force": (over(BALL, (-0.5, 0.1, 0.0), (0.5, 0.1, 0.0), 0), np.zeros(1)),
    "sphere, ends in line with its centre": (
        over(BALL, (-0.5, 0.0, 0.0), (0.5, 0.0, 0.0), 0),
        TIGHT,
    ),
    "cylinder, ends in line with its axis": (
        over(ROLL, (-0.5, 0.0, 0.0), (0.5, 0.0, 0.0), 0),
        TIGHT,
    ),
    "just touching": (over(ROLL, (-0.5, 0.25, 0.0), (0.5, 0.25, 0.0), 0), TIGHT),
    "an end on the surface": (over(ROLL, (-0.25, 0.0, 0.0), (0.5, 0.0, 0.1), 1), TIGHT),
    "an end in the centre": (over(BALL, (0.0, 0.0, 0.0), (0.5, 0.0, 0.1), 1), TIGHT),
    "no length": (straight((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), TIGHT),
    "at its limit": (
        stopped(over(BALL, (-0.5, 0.1, 0.0), (0.5, 0.1, 0.0), 0), 0.0),
        np.zeros(1),
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", KINKS)
def test_kinks(name: str, tmp_path: Path) -> None:
    """Derivatives at kinks are finite and bounded."""
    robot, commands = KINKS[name]
    matrix = derivatives(robot, tmp_path, np.zeros(3), commands)
    assert np.isfinite(matrix).all()
    assert np.abs(matrix).max() < 1e3


def test_side_of_a_kink(tmp_path: Path) -> None:
    """A negative force is a slack cable: its derivatives are zero, others do not change."""
    robot, commands = KINKS["no force"]
    matrix = derivatives(robot, tmp_path, np.zeros(3), commands - 1e-9)
    assert not matrix[:6, 0].any()
    np.testing.assert_array_equal(matrix[:3, -6:-3], np.eye(3))
    np.testing.assert_array_equal(matrix[3:6, -3:], np.eye(3))


@pytest.mark.slow
def test_fmi_3_is_bit_identical_to_fmi_2(tmp_path: Path) -> None:
    """Arrays in FMI 3.0 and scalars in FMI 2.0."""
    experiment = Experiment.load(EXAMPLES / "pneumatic_elbow", {"plant.energy": False})
    answers = []
    for version in ("2.0", "3.0"):
        file = build(experiment, tmp_path / f"out{version}", compute="c", fmi=version)["plant"]  # type: ignore[arg-type]
        with running(file, tmp_path / f"fmu{version}") as host:
            own = [v for v in host.variables if v.name != "time"]
            outputs = [v for v in own if v.causality == "output"]
            inputs = [v for v in own if v.causality == "input"]
            sizes = [sum(int(np.prod(v.shape or 1)) for v in some) for some in (inputs, outputs)]
            references = [[v.valueReference for v in some] for some in (outputs, inputs)]
            more = [sizes[1]] if version == "3.0" else []
            seeds = list(np.linspace(-1, 1, sizes[0]))
            answers.append(list(host.slave.getDirectionalDerivative(*references, seeds, *more)))
            host.slave.terminate()
    assert answers[0] == answers[1]
    assert np.any(answers[0])
