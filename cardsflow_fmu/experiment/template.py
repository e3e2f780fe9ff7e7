"""A first experiment for a robot: a gentle motion, with comments on what else can be said."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from addin_sdfusion.exporting.experiment_text import can_run, gentle_motion, point_lines, toml_key
from addin_sdfusion.robot import InputError, Robot
from addin_sdfusion.robot.files import is_folder
from addin_sdfusion.robot.json_text import json_text
from addin_sdfusion.robot.readers import read
from cardsflow_fmu.config.schema import json_schema
from cardsflow_fmu.signals.muscles import modelled_muscles

from .settings.file import ExperimentTables

EXPERIMENT_TOML = "experiment.toml"

_GAINS = (400.0, 40.0)  # kp in [1/s²], kd in [1/s]: critically damped at 20 rad/s
_SLOW_GAINS = (150.0, 25.0)  # for muscles that take their time
_PERIOD, _STEP = 0.005, 0.001

Form = Mapping[str, Any]

_BESIDE = ("start", "disturbance", "world", "robots", "wiring", "fmus", "hardware")
"""Tables that a first experiment does without."""


def init(
    robot: str | Path, output: str | Path = EXPERIMENT_TOML, cable_set: str | None = None
) -> Path:
    """Write an experiment.toml for a robot, which `cardsflow run` runs as it is.

    Args:
        robot: A model.sdf, a *_bodies.xml, or their folder.
        output: The file, or a folder for experiment.toml.
        cable_set: The cable set to use; the file's own when None.

    Returns:
        The file.

    Raises:
        InputError: The file is there already or cannot be written, or the robot cannot be moved.
        RobotError: The robot cannot be used.
    """
    file = Path(output)
    if is_folder(file) or not file.suffix:
        file /= EXPERIMENT_TOML
    if file.suffix != ".toml":
        raise InputError("an experiment is a .toml", file=file, key="-o")
    found = read(robot, cable_set).require()
    if not can_run(found):
        lack = "no muscles" if found.coordinates else "no joints that move"
        raise InputError(f"robot {found.name!r} has {lack}: there is nothing to run", file=robot)
    text = experiment_text(found, _path_from(file.parent, Path(robot)), cable_set)
    _write_new(file, text)
    return file


def _write_new(file: Path, text: str) -> None:
    """Write a file that is not there, or nothing."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with file.open("x", encoding="utf-8") as stream:
            stream.write(text)
    except (OSError, ValueError) as error:
        if isinstance(error, FileExistsError) and os.path.lexists(file):
            what = "is there already, and is not overwritten; choose another place by -o"
            raise InputError(what, file=file) from None
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"cannot be written: {reason}", file=file) from None


def _path_from(folder: Path, robot: Path) -> str:
    """The way from the experiment's folder to the robot; the whole path on another drive."""
    try:
        return Path(os.path.relpath(robot.resolve(), folder.resolve())).as_posix()
    except ValueError:
        return robot.resolve().as_posix()


def experiment_text(robot: Robot, path: str, cable_set: str | None = None) -> str:
    """The text of an experiment.toml.

    Args:
        robot: The robot, with a muscle and a coordinate at least.
        path: Where its files are, from the experiment's folder.
        cable_set: The cable set that is asked for; None for the file's own.
    """
    tables: Form = json_schema(ExperimentTables)["properties"]
    keys = ("robot", "reference", "controller", "plant", "run")
    own_robot, reference, controller, plant, run = (tables[key] for key in keys)
    motion = gentle_motion(robot)
    kp, kd = _SLOW_GAINS if modelled_muscles(robot) else _GAINS
    lines = [
        f"# {' '.join(robot.name.split())}: a gentle motion from the first pose to one nearby",
        "# and back, simulated by `cardsflow run` of it. Lines in `#` say what else there is;",
        "# `cardsflow schema` prints what editors need to complete and check it.",
        "",
        "[robot]",
        *_line("path", path, own_robot),
        *_line("cable_set", cable_set or robot.cable_set, own_robot, used=bool(cable_set)),
        *_line("gravity", list(robot.gravity), own_robot, used=False),
        *_muscles(robot, tables["muscles"]),
        "",
        f"[reference]  # {_meaning(reference)}",
        *_line("spline", motion.spline, reference),
        *point_lines(robot.coordinates, motion.points),
        "",
        "[controller]",
        *_line("type", "joint_space", controller),
        *_line("kp", kp, controller),
        *_line("kd", kd, controller),
        *_line("period", _PERIOD, controller),
        *_defaults(controller, {"ki", "observer", "delay", "predict", "muscle_horizon", "engine"}),
        "",
        "[plant]",
        *_line("step", _STEP, plant),
        *_defaults(plant, {"mass_scale", "integrator", "engine", "substeps", "energy"}),
        "",
        "[run]",
        *_line("step", _STEP, run),
        *_line("duration", motion.points[-1].time, run),
        *_line("output", "results", run),
        *_defaults(run, {"format", "coupling"}),
        "",
        "# Other tables:",
        *(f"# [{name}]  {_meaning(tables[name])}" for name in _BESIDE),
    ]
    return "\n".join(lines) + "\n"


def _muscles(robot: Robot, form: Form) -> Iterator[str]:
    muscle, keys = robot.muscles[0], form["additionalProperties"]
    yield ""
    yield f"# {_meaning(form)}"
    yield f"# [muscles.{toml_key(muscle.name)}]"
    f_max = muscle.f_max if muscle.f_max < float("inf") else max(100.0, muscle.f_min)
    yield from _line("f_min", muscle.f_min, keys, used=False)
    yield from _line("f_max", f_max, keys, used=False)


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
