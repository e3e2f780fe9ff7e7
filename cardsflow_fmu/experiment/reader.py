"""Reading experiment.toml: every table by a function, every error with file and key."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast, get_args

from addin_sdfusion.robot import InputError, Robot, UnknownNameError
from addin_sdfusion.robot.files import read_file
from addin_sdfusion.robot.readers import Reading, read
from cardsflow_fmu.config.key_path import set_value
from cardsflow_fmu.config.table import Table
from cardsflow_fmu.cosim.coupling import SCHEMES, Coupling, Scheme
from cardsflow_fmu.signals.ports import (
    coordinate_signals,
    load_signals,
    muscle_signals,
    task_signals,
)
from cardsflow_fmu.signals.roles import ROLES
from cardsflow_fmu.signals.world import wrench_signals

from .controller import followed_space, read_controller
from .experiment import (
    MOST_SUBSTEPS,
    DisturbanceSettings,
    Engine,
    Experiment,
    PlantSettings,
    ReferenceSettings,
    Rule,
    RunSettings,
)
from .external_fmus import read_fmus
from .hardware import read_hardware
from .muscles import with_muscle_settings
from .reference import read_reference
from .robot_overrides import changed_robot, read_changes
from .robots import RobotPart, combined, read_parts
from .schema import EXPERIMENT
from .table_forms import TABLE_FORMS, TableForm

if TYPE_CHECKING:
    from sim_dart.scene import Scene

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
        set_value(data, key, value, file)
    top = Table(data, file, form=EXPERIMENT)
    top.refuse_unknown()
    return _experiment(top)


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


def _experiment(top: Table) -> Experiment:
    parts = _parts(top)
    changes: dict[str, Any] = {}
    if parts:
        reading, robot = combined(parts, top)
    else:
        reading, robot, changes = _robot(top.table("robot"))
    top.value("robot", None)
    robot = with_muscle_settings(robot, top.table("muscles"))
    controller = top.table("controller")
    start, reference = read_reference(
        top.table("start"), top.table("reference"), followed_space(controller), reading, robot
    )
    run = _run(top.table("run"), reference)
    disturbance = _disturbance(top.table("disturbance"), robot)
    scene = _world(top.table("world"), robot, reading)
    plant = _plant(top.table("plant"), robot, run, scene)
    experiment = Experiment(
        file=top.file,
        robot=robot,
        robot_path=reading.files[0],
        robot_files=reading.files,
        reference=reference,
        disturbance=disturbance,
        start=start,
        plant=plant,
        controller=read_controller(controller, robot, run, reference, start),
        run=run,
        wiring=_wiring(top.table("wiring"), robot, disturbance, plant),
        fmus=read_fmus(top.table("fmus")),
        robot_changes=changes,
        scene=scene,
        parts=parts,
        hardware=read_hardware(top.table("hardware"), robot, run.step),
    )
    top.close()
    return experiment


def _parts(top: Table) -> tuple[RobotPart, ...]:
    """The robots of [[robots]]; none where there is one [robot]."""
    rows = top.value("robots", None)
    if rows is None:
        return ()
    if "robot" in top:
        raise top.error("robots", "there is a [robot] as well; give one of them")
    if not isinstance(rows, list) or not rows or not all(isinstance(row, dict) for row in rows):
        raise top.error("robots", "must be a list of tables: [[robots]]")
    tables = [top.element("robots", k, row) for k, row in enumerate(rows)]
    return read_parts(tables, _robot)


def _robot(table: Table) -> tuple[Reading, Robot, dict[str, Any]]:
    path = table.file.parent / table.text("path")
    cable_set = table.text("cable_set", "")
    task_set = table.text("operational_space", "")
    gravity = table.numbers("gravity", 3) if "gravity" in table else None
    table.value("gravity", None)
    changes = read_changes(table)
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
    robot = changed_robot(robot, changes, table)
    _require_port_names(table, robot)
    if not robot.coordinates:
        raise table.error("path", f"robot {robot.name!r} has no joint that moves")
    if not robot.muscles:
        raise table.error("path", f"robot {robot.name!r} has no muscles")
    return reading, robot, changes


def _require_port_names(table: Table, robot: Robot) -> None:
    """Names that stay different as parts of FMI variable names."""
    try:
        coordinate_signals("q", robot)
        muscle_signals("f", robot)
        task_signals("y", robot)
    except InputError as error:
        raise table.error("path", error.what) from None


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


def _world(table: Table, robot: Robot, reading: Reading) -> Scene | None:
    if table.is_empty:
        return None
    from .world import read_world  # it needs DART, which others can do without

    return read_world(table, robot, reading.files[0].parent.resolve())


def _plant(table: Table, robot: Robot, run: RunSettings, scene: Scene | None) -> PlantSettings:
    step = table.positive("step", run.step)
    links = [link.name for link in robot.links]
    scales = table.by_name("mass_scale", "link", links, 1.0)
    integrator = cast(Rule, table.choice("integrator", "integrator", get_args(Rule), "euler"))
    substeps = table.whole("substeps", 1)
    energy = table.flag("energy", False)
    wrenches = _wrenches(table, robot)
    engine = cast(Engine, table.choice("engine", "engine", get_args(Engine), "auto"))
    table.close()
    if min(scales) <= 0:
        raise table.error("mass_scale", "must be above 0")
    if substeps < 1:
        raise table.error("substeps", f"must be at least 1, not {substeps}")
    if substeps > MOST_SUBSTEPS:
        raise table.error("substeps", f"must be at most {MOST_SUBSTEPS}, not {substeps}")
    rough = [c.name for c in robot.coordinates if c.friction]
    if integrator == "rk4" and rough:
        what = f"rk4 knows no Coulomb friction, and {', '.join(rough)} has some; use 'euler'"
        raise table.error("integrator", what)
    if integrator == "rk4" and scene is not None:
        raise table.error(
            "integrator", "rk4 knows no contacts, and there is a [world]; use 'euler'"
        )
    if engine == "core" and scene is not None:
        raise table.error("engine", 'the core has no contacts; use engine = "dart"')
    table.multiple("step", run.step, step, "plant.step", blame="run.step")
    return PlantSettings(step, scales, integrator, substeps, energy, wrenches, engine)


def _wrenches(table: Table, robot: Robot) -> tuple[str, ...]:
    """The links that take wrenches, of other names than task points that take forces."""
    names, links = table.value("wrenches", []), [link.name for link in robot.links]
    if not isinstance(names, list | tuple):
        raise table.error("wrenches", f"must be a list of links, not {names!r}")
    for name in names:
        if name not in links:
            raise table.unknown("wrenches", "link", str(name), links)
    taken = set(load_signals(robot)).intersection(wrench_signals(names))
    if taken:
        what = f"{sorted(taken)[0]!r} is the force on a task point of the same name; rename one"
        raise table.error("wrenches", what)
    return tuple(names)


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
    table: Table, robot: Robot, disturbance: DisturbanceSettings | None, plant: PlantSettings
) -> dict[str, str | float]:
    """Connections by full port names; the master checks that they exist."""
    wiring: dict[str, str | float] = {
        f"plant.{name}": 0.0 for name in wrench_signals(plant.wrenches)
    }
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
