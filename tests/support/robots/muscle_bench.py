"""Test bench with muscles at a sliding link, whose length and speed a test sets."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import (
    WORLD,
    CableModel,
    CableSet,
    Coordinate,
    Inertia,
    Joint,
    Link,
    Muscle,
    Robot,
    ViaPoint,
    prismatic,
)
from addin_sdfusion.robot.model.laws.law import Parameter
from sim_dart.core.arrays import FloatArray
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core, library
from sim_dart.muscles.laws import MuscleLaws

WINCH = {
    "drum_radius": 0.05,
    "gear_ratio": 5.0,
    "motor_inertia": 2e-4,
    "dry_friction": 0.1,
    "axial_stiffness": 1e4,
    "dissipation": 1e-3,
    "lead_length": 0.5,
    "max_torque": 2.0,
}
HILL = {"max_isometric_force": 1000.0, "optimal_fibre_length": 0.1, "tendon_slack_length": 0.2}
"""Parameters without defaults, with the default values of OpenSim."""

CURVES = "active_force_length", "force_velocity", "passive_force_length", "tendon_force_length"
"""Names of the curves of Hill-type muscles."""

SOUND: dict[str, dict[str, float]] = {
    "ideal": {},
    "elastic_cable": {"stiffness": 2e4, "damping": 30.0},
    "passive_spring": {"K": 400.0, "l0": 0.3},
    "series_elastic_motor": {},
    "mckibben": {"thread_length": 0.35, "turns": 1.5, "cord_length": 0.05},
    "hill_degroote2016": HILL,
    "hill_millard2012": HILL,
    "hill_thelen2003": HILL,
    "hill_schutte1993": HILL,
    "ligament_blankevoort1991": {"linear_stiffness": 5000.0, "slack_length": 0.28},
    "mujoco_muscle": {"force": 1000.0, "length_low": 0.2, "length_high": 0.35},
    "path_spring": {"stiffness": 5000.0, "rest_length": 0.28, "dissipation": 0.01},
    "tendon_spring": {"stiffness": 400.0, "rest_low": 0.1, "rest_high": 0.25, "damping": 30.0},
    "winch": WINCH,
    "winch_position": WINCH | {"position_gain": 100.0, "velocity_gain": 5.0},
    "heavy_cable": {"axial_stiffness": 1e4, "mass_per_length": 0.5, "damping": 30.0},
}
"""Valid parameters for every muscle law."""


BROKEN_RULES: list[tuple[str, dict[str, float], str]] = [
    ("hill_degroote2016", {"elastic_tendon": 0.5}, "elastic_tendon == 0 or elastic_tendon == 1"),
    (
        "hill_thelen2003",
        {"elastic_tendon": 1.0, "tendon_slack_length": 0.0},
        "elastic_tendon == 0 or tendon_slack_length > 0",
    ),
    ("hill_thelen2003", {"linear_from": 1.0}, "linear_from < 1"),
    ("hill_thelen2003", {"linear_from": 0.7}, "linear_from > 1 / eccentric_force"),
    (
        "hill_millard2012",
        {"pennation_at_optimal": 1.2, "maximum_pennation": 1.0},
        "pennation_at_optimal < maximum_pennation",
    ),
    (
        "hill_millard2012",
        {"active_transition": 0.4},
        "active_shortest < active_transition < 0.95 and 1.1 < active_longest",
    ),
    ("hill_millard2012", {"active_shallow_slope": 5.0}, "active_shallow_slope < mean_rise"),
    ("hill_millard2012", {"active_minimum": 0.5}, "active_minimum < at_transition / 2"),
    (
        "hill_millard2012",
        {"concentric_slope_at_vmax": 0.3},
        "concentric_slope_at_vmax <= concentric_slope_near_vmax",
    ),
    (
        "hill_millard2012",
        {"eccentric_slope_at_vmax": 0.2},
        "eccentric_slope_at_vmax <= eccentric_slope_near_vmax",
    ),
    (
        "hill_millard2012",
        {"eccentric_slope_near_vmax": 0.45},
        "eccentric_slope_near_vmax < eccentric_force - 1",
    ),
    ("hill_millard2012", {"concentric_slope_near_vmax": 1.0}, "concentric_slope_near_vmax < 1"),
    (
        "hill_millard2012",
        {"isometric_slope": 1.01},
        "isometric_slope > max(eccentric_force - 1, 1) / 0.9",
    ),
    (
        "hill_millard2012",
        {"passive_zero_strain": 0.7},
        "passive_fibre_strain > passive_zero_strain",
    ),
    ("hill_millard2012", {"passive_stiffness_low": 3.0}, "passive_stiffness_low < mean_stiffness"),
    (
        "hill_millard2012",
        {"passive_stiffness": 1.0},
        "passive_stiffness == 0 or passive_stiffness > mean_stiffness",
    ),
    (
        "hill_millard2012",
        {"tendon_stiffness": 10.0},
        "tendon_stiffness == 0 or tendon_stiffness > 1 / tendon_strain",
    ),
    ("series_elastic_motor", {"inductance": 1e-9}, "quickness <= 1e6"),
    ("mujoco_muscle", {"length_low": 0.35}, "length_low < length_high"),
    ("mujoco_muscle", {"force": -1.0}, "force >= 0 or acc0 > 0"),
    ("mujoco_muscle", {"range_low": 1.05}, "range_low < range_high"),
    (
        "mujoco_muscle",
        {"passive_range_low": 1.0},
        "passive_range_low < passive_range_high"
        " or (passive_range_low == 0 and passive_range_high == 0)",
    ),
    ("mujoco_muscle", {"lmin": 1.0}, "lmin < 1"),
    ("mujoco_muscle", {"passive_lmax": 0.5}, "passive_lmax == 0 or passive_lmax > 1"),
    ("mujoco_muscle", {"control_low": 0.8, "control_high": 0.5}, "control_low <= control_high"),
    ("tendon_spring", {"rest_low": 0.3}, "rest_low <= rest_high"),
]
"""Invalid parameters of a law, and the rule of the table that they violate."""


def values_outside_bounds(parameter: Parameter) -> list[float]:
    """Return finite values outside the bounds of a parameter, one for each bound."""
    low, high = parameter.low, parameter.high
    below = [low - 1.0, *([low] if parameter.open_low else [])]
    return [*(below if low > -math.inf else []), *([high + 1.0] if high < math.inf else [])]


def slider(*models: tuple[str, Mapping[str, float]]) -> Robot:
    """Return a link that slides along x, with muscles `m0`, `m1`, ... of length |x|."""
    muscles = tuple(
        Muscle(
            f"m{i}",
            (ViaPoint(WORLD, (0.0, 0.0, 0.0)), ViaPoint("slider", (0.0, 0.0, 0.0))),
            0.0,
            1e4,
            CableModel(kind, tuple(parameters.items())),  # type: ignore[arg-type]
        )
        for i, (kind, parameters) in enumerate(models)
    )
    slide = Coordinate("slide", unit="m", lower=-1e9, upper=1e9)
    return Robot(
        "slider",
        (Link("slider", Inertia(1.0, (0.0, 0.0, 0.0), 1e-2, 1e-2, 1e-2)),),
        (Joint("slide", WORLD, "slider", prismatic((1.0, 0.0, 0.0)), (slide,)),),
        (CableSet("all", muscles),),
        "all",
    )


def state_rates(core: Core, commands: ArrayLike, count: int = -1) -> FloatArray:
    """Return the rates of `count` states of muscle laws (default: all, at least one)."""
    bad = core.update_law_rates(core.handle, np.asarray(commands, dtype=np.float64).tobytes())
    assert not bad
    return core.array("law_rates", count).copy()


class Bench:
    """Muscles of given laws between the world and a slider.

    Attributes:
        robot: The robot.
        kinds: Names of the muscle laws.
        laws: The muscle laws.
    """

    def __init__(self, *models: tuple[str, Mapping[str, float]]) -> None:
        robot = self.robot = slider(*models)
        self.kinds = tuple(kind for kind, _ in models)
        self._core = Core(compile_blob(robot))
        self.laws = MuscleLaws(robot, self._core)
        self._size = len(models)

    def move(self, length: float, speed: float = 0.0) -> None:
        """Set length and speed."""
        self._core.move(self._core.handle, np.array([float(length)]).tobytes())
        self.laws.update_rates([speed])

    def start(self, length: float, command: float) -> float:
        """Return the initial tension of the first muscle after a long rest."""
        self.move(length)
        self.laws.start(self._all(command))
        return self.tension(length, 0.0, command)

    def tension(
        self, length: float, speed: float, command: float, states: ArrayLike | None = None
    ) -> float:
        """Return the tension of the first muscle."""
        self.move(length, speed)
        if states is not None:
            self.laws.set_states(states)
        return float(self.laws.drive([speed], self._all(command))[0])

    def state_rates(
        self, length: float, speed: float, command: float, states: ArrayLike
    ) -> FloatArray:
        """Return the derivatives of the states."""
        self.move(length, speed)
        self.laws.set_states(states)
        return state_rates(self._core, self._all(command), len(self.laws.states))

    def curve(self, name: str, x: ArrayLike, *, slope: bool = False, muscle: int = 0) -> FloatArray:
        """Return values or slopes of a curve of a Hill-type muscle; NaN without this curve."""
        evaluate, c = library().core_curve, ctypes
        evaluate.argtypes = [c.c_void_p, c.c_int32, c.c_char_p, c.c_double, c.c_int]
        evaluate.restype = c.c_double
        points = np.asarray(x, dtype=np.float64)
        handle = self._core.handle
        values = [evaluate(handle, muscle, name.encode(), p, slope) for p in points.reshape(-1)]
        return np.array(values).reshape(points.shape)

    def advance(self, length: float, speed: float, command: float, h: float) -> None:
        """Advance by a time from a length with a speed."""
        self.move(length, speed)
        self.laws.advance(self._all(command), h)

    def _all(self, command: float) -> FloatArray:
        return np.full(self._size, float(command))
