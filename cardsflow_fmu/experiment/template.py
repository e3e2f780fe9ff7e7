"""Text of a first experiment.toml, with comments on further settings."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from textwrap import wrap
from typing import Any

from addin_sdfusion.robot import Coordinate, Robot
from addin_sdfusion.robot.model.trajectory import Trajectory, TrajectoryPoint
from cardsflow_fmu.experiment.config.key_path import EVERY_OTHER, toml_key, toml_value
from cardsflow_fmu.experiment.config.schema import json_schema

from .settings.file import ExperimentTables

Form = Mapping[str, Any]

_OTHER_TABLES = ("start", "disturbance", "world", "robots", "wiring", "fmus", "hardware", "about")
"""Tables that a first experiment does not contain."""

_INTRODUCTION = (
    "{}: {}. Simulate it with `cardsflow run`. Lines with `#` show further settings and their "
    "defaults. `cardsflow schema` prints a JSON Schema for editors."
)


@dataclass(frozen=True)
class ExperimentDraft:
    """Content of a first experiment.

    Attributes:
        motion: The reference motion of the coordinates that are not locked.
        summary: Description of the motion.
        file: File of the motion, without noise; empty to write its points.
        locked: Locked coordinates: position in [rad] or [m], and reason, by name.
        springs: Stiffness, rest position and damping of springs that could replace a lock, in SI
            units, by coordinate without drive.
        dependent: Names of coordinates that closed loops determine.
        f_max: Force limits that the robot files do not specify, in [N], by muscle.
        f_max_reason: Comment on these limits.
        kp, kd: Gains, in [1/s²] and [1/s].
        observer: Bandwidth of the disturbance observer, in [rad/s]; 0: no observer.
        period, step: Controller period and simulation step, in [s].
        notes: Notes for users, one line each.
    """

    motion: Trajectory
    locked: Mapping[str, tuple[float, str]] = field(default_factory=dict)
    springs: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    dependent: Collection[str] = ()
    f_max: Mapping[str, float] = field(default_factory=dict)
    f_max_reason: str = ""
    kp: float = field(kw_only=True)
    kd: float = field(kw_only=True)
    observer: float = field(default=0.0, kw_only=True)
    period: float = field(kw_only=True)
    step: float = field(kw_only=True)
    notes: tuple[str, ...] = ()
    summary: str = "a gentle motion from the first pose to one nearby and back"
    file: str = ""


def experiment_text(
    robot: Robot, path: str, draft: ExperimentDraft, cable_set: str | None = None
) -> str:
    """Return the text of an experiment.toml.

    Args:
        robot: The robot, with at least one muscle and one coordinate.
        path: Path of the robot, relative to the folder of the experiment.
        draft: Content of the experiment.
        cable_set: Name of the cable set; None for the default of the robot file.
    """
    tables: Form = json_schema(ExperimentTables)["properties"]
    keys = ("robot", "reference", "controller", "plant", "run")
    own_robot, reference, controller, plant, run = (tables[key] for key in keys)
    motion = draft.motion
    moving = [c for c in robot.coordinates if c.name not in draft.locked]
    lines = [
        *(
            f"# {line}"
            for line in wrap(_INTRODUCTION.format(" ".join(robot.name.split()), draft.summary), 96)
        ),
        *(f"# {line}" for note in draft.notes for line in wrap(note, 96)),
        "",
        "[robot]",
        *_line("path", path, own_robot),
        *_line("cable_set", cable_set or robot.cable_set, own_robot, used=bool(cable_set)),
        *_line("gravity", list(robot.gravity), own_robot, used=False),
        *_locked(robot, draft),
        *_muscles(robot, draft, tables["muscles"]),
        "",
        f"[reference]  # {_description(reference)}",
        *_motion(draft, moving, reference),
        "",
        "[controller]",
        *_line("type", "joint_space", controller),
        *_line("kp", draft.kp, controller),
        *_line("kd", draft.kd, controller),
        *_line("period", draft.period, controller),
        *_dependent(draft),
        *(f"# passive.{toml_key(name)} = true" for name in draft.springs),
        *_default_lines(controller, {"ki"}),
        *_line("observer", draft.observer, controller, used=draft.observer > 0.0),
        *_default_lines(controller, {"delay", "predict", "muscle_horizon", "engine"}),
        "",
        "[plant]",
        *_line("step", draft.step, plant),
        *_default_lines(
            plant, {"mass_scale", "friction_scale", "integrator", "engine", "substeps", "energy"}
        ),
        "",
        "[run]",
        *_line("step", draft.step, run),
        *_line("duration", motion.points[-1].time, run),
        *_line("output", "results", run),
        *_default_lines(run, {"format", "compute", "coupling", "scheme"}),
        "",
        "# Other tables:",
        *(f"# [{name}]  {_description(tables[name])}" for name in _OTHER_TABLES),
    ]
    return "\n".join(lines) + "\n"


def _motion(draft: ExperimentDraft, moving: Sequence[Coordinate], form: Form) -> Iterator[str]:
    """Yield the lines of the reference motion."""
    if draft.file:
        yield from _line("file", draft.file, form)
        yield from _line("noise", 0.0, form)
        return
    yield from _line("spline", draft.motion.spline, form)
    yield from _point_lines(moving, draft.motion.points, draft.dependent)


def _point_lines(
    coordinates: Sequence[Coordinate],
    points: Iterable[TrajectoryPoint],
    without: Collection[str],
) -> Iterator[str]:
    """Yield the lines of one TOML table per point, with units, and with limits at the first one."""
    keys = [toml_key(c.name) for c in coordinates]
    for i, point in enumerate(points):
        yield ""
        yield "[[reference.points]]"
        yield f"time = {point.time!r}  # [s]"
        yield "[reference.points.q]"
        for c, key, q in zip(coordinates, keys, point.q, strict=True):
            if c.name in without:
                continue
            yield f"{key} = {q!r}  # [{c.unit}]" + ("" if i else _limits(c))


def _limits(c: Coordinate) -> str:
    if not (math.isfinite(c.lower) or math.isfinite(c.upper)):
        return ""
    return f", limits {c.lower!r} to {c.upper!r}"


def _locked(robot: Robot, draft: ExperimentDraft) -> Iterator[str]:
    """Yield the lines of locked coordinates, with reasons."""
    if not draft.locked:
        return
    yield ""
    yield "# Locked coordinates. Remove a line if muscles or a motor drive the coordinate:"
    units = {c.name: c.unit for c in robot.coordinates}
    for name, (value, why) in draft.locked.items():
        yield f"coordinates.{toml_key(name)}.locked = {value!r}  # [{units[name]}]; {why}"
    if draft.springs:
        yield "# Alternative: springs and dampers, with controller.passive for these coordinates:"
    for name, (stiffness, rest, damping) in draft.springs.items():
        positions = f"initial = {draft.locked[name][0]!r}, rest = {rest!r}"
        spring = f"{positions}, stiffness = {stiffness!r}, damping = {damping!r}"
        yield f"# coordinates.{toml_key(name)} = {{ {spring} }}"


def _dependent(draft: ExperimentDraft) -> Iterator[str]:
    """Yield the lines of coordinates that closed loops determine."""
    if not draft.dependent:
        return
    yield "# Closed loops determine these coordinates; only the others have reference and gains:"
    for name in draft.dependent:
        yield f"dependent.{toml_key(name)} = true"


def _muscles(robot: Robot, draft: ExperimentDraft, form: Form) -> Iterator[str]:
    if not robot.muscles:
        return
    muscle, keys = robot.muscles[0], form["additionalProperties"]
    yield ""
    yield f"# {_description(form)}"
    if draft.f_max:
        yield "[muscles]"
        yield from (f"# {line}" for line in wrap(draft.f_max_reason, 96))
        for name, value in _merge_equal_values(robot, draft.f_max).items():
            yield f"{toml_key(name)}.f_max = {value!r}  # [N]"
        return
    yield f"# [muscles.{toml_key(muscle.name)}]"
    f_max = muscle.f_max if muscle.f_max < float("inf") else max(100.0, muscle.f_min)
    yield from _line("f_min", muscle.f_min, keys, used=False)
    yield from _line("f_max", f_max, keys, used=False)


def _merge_equal_values(robot: Robot, values: Mapping[str, float]) -> Mapping[str, float]:
    """Return a single pattern if all muscles have the same value, otherwise all values."""
    names = {muscle.name for muscle in robot.muscles}
    shared = len(set(values.values())) == 1 and names == set(values) and len(names) > 1
    if not shared or EVERY_OTHER in names:
        return values
    return {EVERY_OTHER: next(iter(values.values()))}


def _default_lines(form: Form, keys: set[str]) -> Iterator[str]:
    """Yield commented-out lines of settings with their defaults."""
    for key, schema in form["properties"].items():
        if key in keys:
            yield from _line(key, schema["default"], form, used=False)


def _line(key: str, value: Any, form: Form, *, used: bool = True) -> Iterator[str]:
    """Yield the line of a setting, with its description as comment."""
    schema: Mapping[str, Any] = form["properties"][key]
    if isinstance(value, str) and not value:
        return
    setting = f"{'' if used else '# '}{key} = {toml_value(value)}"
    description = schema.get("description", "")
    if "enum" in schema:
        description = f"{', '.join(schema['enum'])}; {description}"
    yield f"{setting:<31} # {description}"


def _description(form: Form) -> str:
    return str(form["description"])
