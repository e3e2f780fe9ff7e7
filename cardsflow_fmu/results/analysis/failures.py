"""Failures of muscles and motors that a robot survives along its reference: `cardsflow faults`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, combinations
from typing import Any

import numpy as np

from addin_sdfusion.robot import Robot
from cardsflow_fmu.cosim.signals.muscles import commanded_muscles, driven_muscles
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.text_table import table
from controllers.analysis.failures import required_strength
from controllers.analysis.inverse_dynamics import MotionTerms

from .redundancy.static import force_range
from .sizing import actuator_terms, required_motion

MAX_POINTS = 200
"""Maximum number of points of the motion."""


@dataclass(frozen=True)
class Failure:
    """Failure of one or several muscles or motors.

    Attributes:
        actuators: Their names; empty for the intact robot.
        strength: Strength that the others need at each point of the motion, relative to their
            force limits, shape (T,); infinite where the motion is impossible.
        times: Times of the points, shape (T,), in [s].
    """

    actuators: tuple[str, ...]
    strength: FloatArray
    times: FloatArray

    @property
    def is_survived(self) -> bool:
        """Whether the others can produce the whole motion within their limits."""
        return bool(self.strength.max() <= 1.0)

    @property
    def worst_time(self) -> float:
        """Time of the largest strength, in [s]."""
        return float(self.times[np.argmax(self.strength)])

    def as_dict(self) -> dict[str, Any]:
        """Return the failure as plain data."""
        peak = float(self.strength.max())
        return {
            "actuators": list(self.actuators),
            "survived": self.is_survived,
            "margin": 1.0 - peak if np.isfinite(peak) else None,
            "time": self.worst_time,
            "infeasible": float((self.strength > 1.0).mean()),
        }


def failures(
    experiment: Experiment,
    largest: int = 1,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> list[Failure]:
    """Return the strength that the reference needs without some muscles or motors.

    Passive muscles do not fail.

    Args:
        largest: Largest number of simultaneous failures, 1 or 2.
        progress: Function of the number of computed failures and of all failures.

    Returns:
        The intact robot, single failures, then pairs.

    Raises:
        InputError: The robot has no muscles and no motors, or cannot reach the reference.
    """
    robot, motion = required_motion(experiment, motion_points(experiment))
    robot, terms = actuator_terms(robot, motion)
    driven = [*sorted(commanded_muscles(robot)), *range(len(robot.muscles), len(terms.f_min))]
    limits = force_limits(robot, terms)
    cases = list(chain.from_iterable(combinations(driven, k) for k in range(largest + 1)))
    results: list[Failure] = []
    for case in cases:
        progress(len(results), len(cases))
        names = tuple(terms.muscle_names[k] for k in case)
        results.append(Failure(names, required_strength(terms, case, limits), terms.motion.times))
    return results


def force_limits(robot: Robot, terms: MotionTerms) -> tuple[FloatArray, FloatArray]:
    """Return the force limits of all actuators along a motion, shape (T, a) each.

    Muscles without a limit f_max have those of their law.

    Raises:
        InputError: The law of a muscle has no limits either.
    """
    shape = terms.L.shape[:2]
    low, high = np.broadcast_to(terms.f_min, shape), np.broadcast_to(terms.f_max, shape)
    driven = driven_muscles(robot)
    unlimited = [k for k in driven if not np.isfinite(terms.f_max[k])]
    if unlimited:
        low, high = low.copy(), high.copy()
        least, most = force_range(robot, terms.motion)
        low[:, unlimited], high[:, unlimited] = least[:, unlimited], most[:, unlimited]
    return low, high


def motion_points(experiment: Experiment) -> int:
    """Return the number of points of the motion."""
    periods = int(experiment.run.duration / experiment.controller.period)
    return min(max(periods + 1, 5), MAX_POINTS)


def describe_failures(results: Sequence[Failure], reactions: Mapping[str, str] = {}) -> str:
    """Return the failures as text, with the result in the first line."""
    intact, *others = results
    parts = [_result(intact, others)]
    times = intact.times
    parts.append(
        f"{len(times)} points from {times[0]:g} to {times[-1]:g} s; with a margin of "
        "40 %, 60 % of the force limits suffice"
    )
    heads = ["without", "margin", "at [s]", "infeasible", "[faults] would"]
    rows = [
        [
            " and ".join(failure.actuators) or "(intact)",
            _percent(1.0 - failure.strength.max()),
            f"{failure.worst_time:.4g}",
            f"{100 * (failure.strength > 1.0).mean():.0f} %",
            reactions.get(" and ".join(failure.actuators), ""),
        ]
        for failure in results
    ]
    return "\n\n".join([*parts, table(heads, rows)])


def _result(intact: Failure, others: Sequence[Failure]) -> str:
    if not intact.is_survived:
        return (
            "infeasible: the intact robot is too weak for the motion; "
            "`cardsflow size` lists the required forces"
        )
    return "; ".join(_counts(others)) or "the robot has no muscles or motors that can fail"


def _counts(others: Sequence[Failure]) -> Iterator[str]:
    for size, kind in ((1, "single"), (2, "double")):
        cases = [failure for failure in others if len(failure.actuators) == size]
        if cases:
            lost = [" and ".join(f.actuators) for f in cases if not f.is_survived]
            yield f"the motion survives {len(cases) - len(lost)} of {len(cases)} {kind} failures"
            if size == 1 and 0 < len(lost) < len(cases):
                yield f"it is infeasible without {' or '.join(lost)}"


def _percent(margin: float) -> str:
    return f"{100 * margin:.0f} %" if np.isfinite(margin) else "impossible"
