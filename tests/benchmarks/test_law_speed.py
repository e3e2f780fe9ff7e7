"""Cost of muscle laws relative to ideal cables, measured alternately in one run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from support.interleaved import interleaved, record
from support.robots.robots import chain, planar_2r

from addin_sdfusion.robot import CableModel, Robot
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core
from sim_dart.muscles.laws import MuscleLaws

RIGID, ELASTIC = 2.0, 25.0
"""Largest times with Hill-type muscles relative to ideal cables; see `kernel`."""


def _with_law(robot: Robot, kind: str, **parameters: float) -> Robot:
    """Return the robot with a law for all muscles, whose fibres start near their optimal length."""
    lengths = dict(zip(robot.muscles, _lengths(robot), strict=True))
    muscles = []
    for muscle, length in lengths.items():
        hill = {
            "max_isometric_force": 100.0,
            "optimal_fibre_length": 0.4 * length,
            "tendon_slack_length": 0.6 * length,
            "pennation_at_optimal": 0.1,
        }
        model = CableModel(kind, tuple((hill | parameters).items()))  # type: ignore[arg-type]
        muscles.append(replace(muscle, model=model))
    return robot.with_muscles(muscles)


def _lengths(robot: Robot) -> list[float]:
    core = Core(compile_blob(robot))
    core.move(core.handle, np.zeros(len(robot.coordinates)).tobytes())
    lengths: list[float] = core.array("lengths", len(robot.muscles)).tolist()
    return lengths


def kernel(robot: Robot) -> Callable[[], None]:
    """Return a step of the C core: l and L of q, rates, tensions, torques and muscle states."""
    core = Core(compile_blob(robot))
    laws = MuscleLaws(robot, core)
    n, m = len(robot.coordinates), len(robot.muscles)
    rng = np.random.default_rng(0)
    q, qd = rng.uniform(-0.1, 0.1, n).tobytes(), rng.uniform(-0.5, 0.5, n).tobytes()
    u = rng.uniform(0.1, 0.9, m)
    core.move(core.handle, q)
    laws.start(u)
    commands = rng.uniform(0.1, 0.9, m).tobytes()
    start = laws.states.copy()

    def step() -> None:
        laws.states[:] = start
        core.move(core.handle, q)
        core.drive(core.handle, qd, commands)
        core.advance(core.handle, commands, 1e-3)

    return step


@pytest.mark.parametrize(
    ("name", "robot"),
    [("two-link arm", planar_2r()), ("20-joint chain", chain())],
    ids=["arm", "chain"],
)
def test_cost_of_hill_type_muscles(name: str, robot: Robot) -> None:
    """Activation at most doubles the time. An elastic tendon requires a force equilibrium."""
    alternatives = {
        "ideal": kernel(robot),
        "degroote": kernel(_with_law(robot, "hill_degroote2016")),
        "thelen": kernel(_with_law(robot, "hill_thelen2003")),
        "millard": kernel(_with_law(robot, "hill_millard2012")),
        "degroote_elastic": kernel(_with_law(robot, "hill_degroote2016", elastic_tendon=1.0)),
        "millard_elastic": kernel(_with_law(robot, "hill_millard2012", elastic_tendon=1.0)),
    }
    times = interleaved(alternatives, calls=20, rounds=400)
    ratios = {key: seconds / times["ideal"] for key, seconds in times.items() if key != "ideal"}
    record(f"muscle kernel with muscle laws, {name}", us_ideal=times["ideal"] * 1e6, **ratios)
    assert max(ratios[key] for key in ("degroote", "thelen", "millard")) <= RIGID
    assert max(ratios.values()) <= ELASTIC
