"""Reading experiment.toml: every table by a function, every error with file and key."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

from addin_sdfusion.robot import InputError, Muscle, Robot, UnknownNameError
from addin_sdfusion.robot.check import require_valid
from addin_sdfusion.robot.files import read_file
from addin_sdfusion.robot.readers import Reading, read

from .controller_reader import followed_space, read_controller
from .coupling import SCHEMES, Coupling, Scheme
from .experiment import (
    DisturbanceSettings,
    Experiment,
    PlantSettings,
    ReferenceSettings,
    RunSettings,
)
from .foreign_fmu import ROLES, read_fmus
from .hardware_reader import read_hardware
from .ports import coordinate_signals, load_signals, muscle_signals, task_signals
from .reference_reader import read_reference
from .table_forms import TABLE_FORMS, TableForm
from .tables import Table

_MAX_BYTES = 64 * 2**20

Force = tuple[float, float, float]


def read_experiment(path: Path, settings: Mapping[str, Any]) -> Experiment:
    """Read and check an experiment.

    Args:
        path: An experiment.toml, the folder that holds one, or an FMU's experiment.json.
        settings: Changes by full key.

    Raises:
        InputError: Something in it is wrong; the message names file and key.
    """
    file = path / "experiment.toml" if path.is_dir() else path
    data = _read_data(file)
    for key, value in settings.items():
        _set(data, key, value, file)
    return _experiment(Table(data, file))


def _read_data(file: Path) -> dict[str, Any]:
    """The file's content as plain data: TOML, or JSON by its suffix."""
    try:
        text = read_file(file, _MAX_BYTES).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError("is not UTF-8 text", file=file) from None
    try:
        data = json.loads(text) if file.suffix == ".json" else tomllib.loads(text)
    except ValueError as error:
        raise InputError(" ".join(str(error).split()), file=file) from None
    except RecursionError:
        raise InputError("is nested too deeply", file=file) from None
    if not isinstance(data, dict):
        raise InputError("must hold a table", file=file)
    return data


def _set(data: dict[str, Any], key: str, value: Any, file: Path) -> None:
    """Set a value by its full key, making tables on the way."""
    *path, last = key.split(".")
    for part in path:
        data = data.setdefault(part, {})
        if not isinstance(data, dict):
            raise InputError(f"{part!r} is not a table", file=file, key=key)
    data[last] = value


def _experiment(top: Table) -> Experiment:
    reading, robot = _robot(top.table("robot"))
    robot = _with_bounds(robot, top.table("muscles"))
    controller = top.table("controller")
    start, reference = read_reference(
        top.table("start"), top.table("reference"), followed_space(controller), reading, robot
    )
    run = _run(top.table("run"), reference)
    disturbance = _disturbance(top.table("disturbance"), robot)
    experiment = Experiment(
        file=top.file,
        robot=robot,
        robot_path=reading.files[0],
        robot_files=reading.files,
        reference=reference,
        disturbance=disturbance,
        start=start,
        plant=_plant(top.table("plant"), robot, run),
        controller=read_controller(controller, robot, run, reference, start),
        run=run,
        wiring=_wiring(top.table("wiring"), robot, disturbance),
        fmus=read_fmus(top.table("fmus")),
        hardware=read_hardware(top.table("hardware"), robot, run.step),
    )
    top.close()
    return experiment


def _robot(table: Table) -> tuple[Reading, Robot]:
    path = table.file.parent / table.text("path")
    cable_set = table.text("cable_set", "")
    task_set = table.text("operational_space", "")
    gravity = table.numbers("gravity", 3) if "gravity" in table else None
    table.value("gravity", None)
    table.close()
    try:
        reading = read(path, cable_set or None)
    except UnknownNameError as error:
        raise table.unknown("cable_set", "cable set", error.name, error.known) from None
    robot = reading.require()
    if task_set:
        known = [s.name for s in robot.task_sets]
        if task_set not in known:
            raise table.unknown("operational_space", "operational space", task_set, known)
        robot = replace(robot, task_set=task_set)
    if gravity is not None:
        robot = replace(robot, gravity=cast(tuple[float, float, float], gravity))
    _require_port_names(table, robot)
    if not robot.coordinates:
        raise table.error("path", f"robot {robot.name!r} has no joint that moves")
    if not robot.muscles:
        raise table.error("path", f"robot {robot.name!r} has no muscles")
    return reading, robot


def _require_port_names(table: Table, robot: Robot) -> None:
    """Names that stay different as parts of FMI variable names."""
    try:
        coordinate_signals("q", robot)
        muscle_signals("f", robot)
        task_signals("y", robot)
    except InputError as error:
        raise table.error("path", error.what) from None


def _with_bounds(robot: Robot, table: Table) -> Robot:
    """The robot with the force bounds that the experiment changes."""
    muscles = list(robot.muscles)
    for index, changes in table.tables([muscle.name for muscle in muscles], "muscle"):
        muscles[index] = _bounded(muscles[index], changes)
    changed = robot.with_muscles(muscles)
    require_valid(changed)
    return changed


def _bounded(muscle: Muscle, table: Table) -> Muscle:
    f_min = table.number("f_min", muscle.f_min)
    f_max = table.number("f_max") if "f_max" in table else muscle.f_max
    table.value("f_max", None)
    table.close()
    if f_min < 0:
        raise table.error("f_min", f"must not be negative: {f_min!r}")
    if f_min > f_max:
        raise InputError(
            f"f_min {f_min!r} N is above f_max {f_max!r} N", file=table.file, key=table.path
        )
    return replace(muscle, f_min=f_min, f_max=f_max)


def _run(table: Table, reference: ReferenceSettings) -> RunSettings:
    step = table.positive("step", 1e-3)
    duration = table.positive("duration", reference.duration)
    output = table.file.parent / table.text("output", "results")
    coupling = _coupling(table)
    form = cast(TableForm, table.choice("format", "format", TABLE_FORMS, "csv"))
    table.close()
    table.multiple("duration", duration, step, "run.step")
    return RunSettings(duration, step, output, coupling, form)


def _coupling(table: Table) -> Coupling:
    """The coupling scheme; `gauss_seidel` needs an order of all three participants."""
    scheme = cast(Scheme, table.choice("coupling", "coupling", SCHEMES, "sampled"))
    if scheme != "gauss_seidel":
        return Coupling(scheme)
    order = table.value("order")
    if not isinstance(order, list | tuple) or sorted(map(str, order)) != sorted(ROLES):
        raise table.error("order", f"must be a list of {', '.join(ROLES)} in any order")
    return Coupling(scheme, tuple(order))


def _plant(table: Table, robot: Robot, run: RunSettings) -> PlantSettings:
    step = table.positive("step", run.step)
    links = [link.name for link in robot.links]
    scales = table.by_name("mass_scale", "link", links, 1.0)
    table.close()
    if min(scales) <= 0:
        raise table.error("mass_scale", "must be above 0")
    table.multiple("step", run.step, step, "plant.step", blame="run.step")
    return PlantSettings(step, scales)


def _disturbance(table: Table, robot: Robot) -> DisturbanceSettings | None:
    """Forces from outside; None if the table is absent or empty."""
    if table.is_empty:
        return None
    frames = [frame.name for frame in robot.task_frames if not frame.is_orientation]
    given = table.table("force")
    forces = {}
    for name in table.value("force", {}):
        if name not in frames:
            raise given.unknown(name, "task frame that is a point", name, frames)
        forces[name] = given.numbers(name, 3)
    begin = table.number("begin", 0.0)
    end = table.number("end") if "end" in table else math.inf
    table.value("end", None)
    known = table.flag("known", False)
    table.close()
    if end <= begin:
        raise table.error("end", f"must be after begin, {begin!r} s")
    if not forces:
        raise table.error("force", f"missing: forces on {', '.join(frames) or 'task points'}")
    rows = tuple(cast(Force, forces.get(name, (0.0, 0.0, 0.0))) for name in frames)
    return DisturbanceSettings(rows, begin, end, known)


def _wiring(
    table: Table, robot: Robot, disturbance: DisturbanceSettings | None
) -> dict[str, str | float]:
    """Connections by full port names; the master checks that they exist."""
    wiring: dict[str, str | float] = {}
    for model in ("plant", "controller"):
        if disturbance is None or (model == "controller" and not disturbance.known):
            wiring |= {f"{model}.{name}": 0.0 for name in load_signals(robot)}
        inputs = table.table(model)
        for name, source in table.value(model, {}).items():
            wiring[f"{model}.{name}"] = (
                inputs.text(name) if isinstance(source, str) else inputs.number(name)
            )
    table.close()
    return wiring
