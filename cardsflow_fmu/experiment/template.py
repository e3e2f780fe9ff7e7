"""A first experiment for a robot: a gentle motion, with comments on what else can be said."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from textwrap import wrap
from typing import Any

from addin_sdfusion.exporting.experiment_text import point_lines, toml_key
from addin_sdfusion.robot import Coordinate, Robot
from addin_sdfusion.robot.json_text import json_text
from addin_sdfusion.robot.model.trajectory import Trajectory
from cardsflow_fmu.experiment.config.key_path import EVERY_OTHER
from cardsflow_fmu.experiment.config.schema import json_schema

from .settings.file import ExperimentTables

Form = Mapping[str, Any]

_BESIDE = ("start", "disturbance", "world", "robots", "wiring", "fmus", "hardware")
"""Tables that a first experiment does without."""

_TOP = (
    "{}: {}, simulated by `cardsflow run` of it. Lines in `#` say what else there is; `cardsflow "
    "schema` prints what editors need to complete and check it."
)


@dataclass(frozen=True)
class Beginning:
    """What a first experiment of a robot does.

    Attributes:
        motion: The motion to follow, of the coordinates that are left.
        what: It, in words.
        file: Its table beside the experiment, without noise; where empty, its points are written.
        locked: What coordinates are locked at, in [rad] or [m], and why, by name.
        springs: Stiffness, rest and damping that would do instead, in SI units, by name, of those
            that nothing drives.
        dependent: Names of coordinates that follow from the others, by loops.
        f_max: Force bounds that the robot's files lack, in [N], by the muscle's name.
        f_max_reason: Where they come from.
        kp, kd: Gains, in [1/s²] and [1/s].
        observer: Bandwidth of the disturbance observer, in [rad/s]; 0 for none.
        period, step: Of the controller and of the simulation, in [s].
        remarks: What else there is to know, a line each.
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
    remarks: tuple[str, ...] = ()
    what: str = "a gentle motion from the first pose to one nearby and back"
    file: str = ""


def experiment_text(
    robot: Robot, path: str, beginning: Beginning, cable_set: str | None = None
) -> str:
    """The text of an experiment.toml.

    Args:
        robot: The robot, with a muscle and a coordinate at least.
        path: Where its files are, from the experiment's folder.
        beginning: What it does.
        cable_set: The cable set that is asked for; None for the file's own.
    """
    tables: Form = json_schema(ExperimentTables)["properties"]
    keys = ("robot", "reference", "controller", "plant", "run")
    own_robot, reference, controller, plant, run = (tables[key] for key in keys)
    motion = beginning.motion
    left = [c for c in robot.coordinates if c.name not in beginning.locked]
    lines = [
        *(
            f"# {line}"
            for line in wrap(_TOP.format(" ".join(robot.name.split()), beginning.what), 96)
        ),
        *(f"# {line}" for remark in beginning.remarks for line in wrap(remark, 96)),
        "",
        "[robot]",
        *_line("path", path, own_robot),
        *_line("cable_set", cable_set or robot.cable_set, own_robot, used=bool(cable_set)),
        *_line("gravity", list(robot.gravity), own_robot, used=False),
        *_locked(robot, beginning),
        *_muscles(robot, beginning, tables["muscles"]),
        "",
        f"[reference]  # {_meaning(reference)}",
        *_motion(beginning, left, reference),
        "",
        "[controller]",
        *_line("type", "joint_space", controller),
        *_line("kp", beginning.kp, controller),
        *_line("kd", beginning.kd, controller),
        *_line("period", beginning.period, controller),
        *_dependent(beginning),
        *(f"# passive.{toml_key(name)} = true" for name in beginning.springs),
        *_defaults(controller, {"ki"}),
        *_line("observer", beginning.observer, controller, used=beginning.observer > 0.0),
        *_defaults(controller, {"delay", "predict", "muscle_horizon", "engine"}),
        "",
        "[plant]",
        *_line("step", beginning.step, plant),
        *_defaults(
            plant, {"mass_scale", "friction_scale", "integrator", "engine", "substeps", "energy"}
        ),
        "",
        "[run]",
        *_line("step", beginning.step, run),
        *_line("duration", motion.points[-1].time, run),
        *_line("output", "results", run),
        *_defaults(run, {"format", "compute", "coupling", "scheme"}),
        "",
        "# Other tables:",
        *(f"# [{name}]  {_meaning(tables[name])}" for name in _BESIDE),
    ]
    return "\n".join(lines) + "\n"


def _motion(beginning: Beginning, left: Sequence[Coordinate], form: Form) -> Iterator[str]:
    """What is to be followed."""
    if beginning.file:
        yield from _line("file", beginning.file, form)
        yield from _line("noise", 0.0, form)
        return
    yield from _line("spline", beginning.motion.spline, form)
    yield from point_lines(left, beginning.motion.points, beginning.dependent)


def _locked(robot: Robot, beginning: Beginning) -> Iterator[str]:
    """What does not move, and why."""
    if not beginning.locked:
        return
    yield ""
    yield "# Held where they are; free are those whose line is left out, for muscles or a motor:"
    units = {c.name: c.unit for c in robot.coordinates}
    for name, (value, why) in beginning.locked.items():
        yield f"coordinates.{toml_key(name)}.locked = {value!r}  # [{units[name]}]; {why}"
    if beginning.springs:
        yield "# Or left to springs and dampers, which [controller] calls passive then:"
    for name, (stiffness, rest, damping) in beginning.springs.items():
        own = f"initial = {beginning.locked[name][0]!r}, rest = {rest!r}"
        spring = f"{own}, stiffness = {stiffness!r}, damping = {damping!r}"
        yield f"# coordinates.{toml_key(name)} = {{ {spring} }}"


def _dependent(beginning: Beginning) -> Iterator[str]:
    """What follows from the others, where loops close."""
    if not beginning.dependent:
        return
    yield "# Where loops close, these follow from the others, which alone have reference and gains:"
    for name in beginning.dependent:
        yield f"dependent.{toml_key(name)} = true"


def _muscles(robot: Robot, beginning: Beginning, form: Form) -> Iterator[str]:
    if not robot.muscles:
        return
    muscle, keys = robot.muscles[0], form["additionalProperties"]
    yield ""
    yield f"# {_meaning(form)}"
    if beginning.f_max:
        yield "[muscles]"
        yield from (f"# {line}" for line in wrap(beginning.f_max_reason, 96))
        for name, value in _by_pattern(robot, beginning.f_max).items():
            yield f"{toml_key(name)}.f_max = {value!r}  # [N]"
        return
    yield f"# [muscles.{toml_key(muscle.name)}]"
    f_max = muscle.f_max if muscle.f_max < float("inf") else max(100.0, muscle.f_min)
    yield from _line("f_min", muscle.f_min, keys, used=False)
    yield from _line("f_max", f_max, keys, used=False)


def _by_pattern(robot: Robot, values: Mapping[str, float]) -> Mapping[str, float]:
    """One value for all muscles where they share it, which a single name may differ from."""
    names = {muscle.name for muscle in robot.muscles}
    shared = len(set(values.values())) == 1 and names == set(values) and len(names) > 1
    if not shared or EVERY_OTHER in names:
        return values
    return {EVERY_OTHER: next(iter(values.values()))}


def _defaults(form: Form, keys: set[str]) -> Iterator[str]:
    """Settings that are left at their defaults."""
    for key, own in form["properties"].items():
        if key in keys:
            yield from _line(key, own["default"], form, used=False)


def _line(key: str, value: Any, form: Form, *, used: bool = True) -> Iterator[str]:
    """A setting, and what it means."""
    own: Mapping[str, Any] = form["properties"][key]
    if isinstance(value, str) and not value:
        return
    setting = f"{'' if used else '# '}{key} = {_toml(value)}"
    words = own.get("description", "")
    if "enum" in own:
        words = f"{', '.join(own['enum'])}; {words}"
    yield f"{setting:<31} # {words}"


def _meaning(form: Form) -> str:
    return str(form["description"])


def _toml(value: Any) -> str:
    """A value as TOML, whose texts, numbers and lists are written as those of JSON."""
    return json_text(value, ensure_ascii=False).replace("\x7f", "\\u007f")
