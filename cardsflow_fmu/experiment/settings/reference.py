"""Settings of [reference]."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, WithJsonSchema, model_validator

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.model.trajectory import Space, Spline, Trajectory, TrajectoryPoint
from cardsflow_fmu.experiment.config.messages import SettingError
from cardsflow_fmu.experiment.config.names import named_setting
from cardsflow_fmu.experiment.config.table import (
    AS_WHOLE,
    File,
    FromZero,
    Listed,
    Positive,
    Table,
    Text,
    Vector3,
    setting,
)
from cardsflow_fmu.experiment.recorded_motion import FILE_TYPES, is_motion

_WITH_RATES = ("cubic", "quintic", "samples")
_WITH_ACCELERATIONS = ("quintic", "samples")
_RIGHT_ANGLE = 1e-9
_ROWS = {"type": "array", "items": {"type": "array", "items": {"type": "number"}}, "minItems": 2}

_X, _Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


class FlowerSettings(Table):
    """Rose curve r = radius * cos(petals * phi) about a centre; see `FlowerReference`."""

    centre: Vector3 = setting("centre, in m")
    axes: Annotated[tuple[Vector3, ...], Listed] = setting(
        "two orthogonal unit vectors that span the plane", (_X, _Z)
    )
    radius: Positive = setting("radius, in m")
    petals: Annotated[int, Field(ge=1), AS_WHOLE] = setting("number of petals", 5)
    duration: Positive = setting("duration, in s", 30.0)

    @model_validator(mode="after")
    def _check_axes(self) -> Self:
        if len(self.axes) != 2:
            raise SettingError("must be two vectors of three numbers", key="axes")
        u, v = map(np.array, self.axes)
        if max(abs(u @ u - 1.0), abs(v @ v - 1.0), abs(u @ v)) > _RIGHT_ANGLE:
            raise SettingError("must be two orthogonal unit vectors", key="axes")
        return self


class ApproachSettings(Table):
    """Straight motion, from rest to rest, to the first point of the reference."""

    duration: Positive = setting("duration, in s")
    start: Annotated[tuple[float, ...], Listed] = setting(
        "first point, q or y (default: start pose)", None
    )


class PointSettings(Table):
    """Point of the reference. All points contain q, or all contain y."""

    time: float = setting("time, in s; 0 for the first point")
    q: tuple[float, ...] = named_setting("coordinate", "joint positions, in rad or m", None)
    qd: tuple[float, ...] = named_setting("coordinate", "joint velocities, in rad/s or m/s", 0.0)
    qdd: tuple[float, ...] = named_setting(
        "coordinate", "joint accelerations, in rad/s² or m/s²", 0.0
    )
    y: tuple[float, ...] = named_setting("task coordinate", "task coordinates, in m or rad", None)
    yd: tuple[float, ...] = named_setting(
        "task coordinate", "rates of the task coordinates, in m/s or rad/s", 0.0
    )
    ydd: tuple[float, ...] = named_setting(
        "task coordinate", "accelerations of the task coordinates, in m/s² or rad/s²", 0.0
    )
    blend_time: Positive = setting("duration of the parabolic blend, in s", None)


class ReferenceTable(Table):
    """Reference: points, a recorded motion, a named trajectory, a flower, or an optimal motion."""

    type: Literal["optimised", "rest"] = setting(
        "optimised: the motion that `cardsflow optimise` writes; rest: rest at the start (default: "
        "as the other keys specify)",
        None,
    )
    name: Text = setting("name of the trajectory of the points", "reference")
    spline: Spline = setting(
        "interpolation of the points (default: minimum jerk, without stops)",
        None,
        kind="kind of spline",
    )
    points: Annotated[tuple[PointSettings, ...], Listed, Field(min_length=2)] = setting(
        "points with increasing times", None
    )
    trajectory: Text = setting("name of a CASPR trajectory", None)
    file: File = setting(
        "file of the trajectory (default: in the folder of the robot); or a recorded motion: .csv, "
        ".npy, .npz, .mot, .sto, or a ROS 2 recording: .mcap, .db3, rosbag2 folder",
        None,
    )
    samples: Annotated[Any, WithJsonSchema(_ROWS)] = setting(
        "recorded motion: rows of time and positions", None
    )
    noise: FromZero = setting(
        "standard deviation of recorded positions, in rad or m (default: estimated)",
        None,
    )
    flower: FlowerSettings = setting("rose curve in operational space", None)
    approach: ApproachSettings = setting(
        "straight motion, from rest to rest, to the first point of the reference", None
    )

    @model_validator(mode="after")
    def _check_kind(self) -> Self:
        if self.type is not None:
            self.require_only(("type", "file") if self.type == "optimised" else ("type",))
        elif self.flower is not None:
            self.require_only(("flower", "approach"))
        elif self.points is not None:
            self.require_only(("name", "spline", "points", "approach"))
            self._check_points()
        elif self.is_recorded:
            kind = "file" if self.samples is None else "samples"
            self.require_only((kind, "noise", "approach"))
        else:
            self.require_only(("trajectory", "file", "approach"))
            if self.trajectory is None:
                other = f"missing; recorded motions have the file types {', '.join(FILE_TYPES)}"
                raise SettingError("missing" if self.file is None else other, key="trajectory")
        return self

    def _check_points(self) -> None:
        """Check the keys and the times of the points."""
        errors: list[InputError] = []
        for k, point in enumerate(self.points):
            blends = ["blend_time"] if self.spline == "parabolic_blend" and k else []
            point_errors: list[InputError] = point.inapplicable_keys(
                ["time", *self.rows.values(), *blends]
            )
            missing = [key for key in (self.letter, *blends) if not getattr(point, key)]
            point_errors += [InputError("missing", key=key) for key in sorted(missing)]
            for error in point_errors:
                error.key = f"points[{k}].{error.key}"
            errors += point_errors
        if errors:
            raise SettingError(*errors)
        times = [point.time for point in self.points]
        if times[0] != 0 or any(b <= a for a, b in pairwise(times)):
            raise SettingError(f"times must begin at 0 and increase, not {times}", key="points")
        for k, (before, point) in enumerate(pairwise(self.points), 1):
            if 2.0 * (point.blend_time or 0.0) >= point.time - before.time:
                problem = "must be less than half the time since the previous point"
                problem += f", not {point.blend_time!r} s"
                raise SettingError(problem, key=f"points[{k}].blend_time")

    @property
    def is_recorded(self) -> bool:
        """Whether the reference is a recorded motion."""
        by_file = self.trajectory is None and self.file is not None
        return self.samples is not None or (by_file and is_motion(self.file))

    @property
    def letter(self) -> str:
        """Coordinates of the points, from the first point: `q` or `y`."""
        return "y" if "y" in self.points[0].model_fields_set else "q"

    @property
    def rows(self) -> dict[str, str]:
        """Keys of the points by attribute of `TrajectoryPoint`."""
        rows = {"q": self.letter}
        if self.spline in _WITH_RATES:
            rows["qd"] = f"{self.letter}d"
        if self.spline in _WITH_ACCELERATIONS:
            rows["qdd"] = f"{self.letter}dd"
        return rows

    def trajectory_of_points(self) -> Trajectory:
        """Return the trajectory through the points."""
        space: Space = "joint" if self.letter == "q" else "operational"
        if self.spline is None:
            from controllers.references.recorded import waypoint_trajectory

            times = np.array([point.time for point in self.points])
            rows = np.array([getattr(point, self.letter) for point in self.points])
            return waypoint_trajectory(times, rows, self.name, space)
        points = [
            TrajectoryPoint(
                point.time,
                **{name: getattr(point, key) for name, key in self.rows.items()},
                blend_time=point.blend_time or 0.0,
            )
            for point in self.points
        ]
        return Trajectory(self.name, self.spline, tuple(points), points[-1].time, space)


@dataclass(frozen=True, slots=True)
class ReferenceSettings:
    """Trajectory or flower that the controller follows.

    Attributes:
        space: Space of the reference: joint positions q or task coordinates y.
        curve: The trajectory or flower.
        approach: Motion to its first point; None if the robot starts there.
    """

    space: Space
    curve: Trajectory | FlowerSettings
    approach: ApproachSettings | None = None

    @property
    def duration(self) -> float:
        """Duration with the approach, in [s]."""
        curve = self.curve
        seconds = curve.duration if isinstance(curve, FlowerSettings) else curve.points[-1].time
        return seconds + (self.approach.duration if self.approach else 0.0)

    def data(self) -> dict[str, Any]:
        """Return the settings as plain data; reading the data returns equal settings."""
        approach = {} if self.approach is None else {"approach": self.approach.data()}
        if isinstance(self.curve, FlowerSettings):
            return {"flower": self.curve.data(), **approach}
        letter = "q" if self.curve.space == "joint" else "y"
        points = [
            {"time": point.time}
            | {
                letter + ending: list(numbers)
                for ending, numbers in (("", point.q), ("d", point.qd), ("dd", point.qdd))
                if numbers
            }
            | ({"blend_time": point.blend_time} if point.blend_time else {})
            for point in self.curve.points
        ]
        return {"name": self.curve.name, "spline": self.curve.spline, "points": points, **approach}
