"""Reader of experiments: it reads the tables, then the robot, then checks all names."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import InputError, Robot
from addin_sdfusion.robot.formats.read import Reading, holds_robot
from cardsflow_fmu.cosim.signals.estimation import estimation_wiring, measured_muscles
from cardsflow_fmu.cosim.signals.ports import load_signals
from cardsflow_fmu.cosim.signals.world import wrench_signals
from cardsflow_fmu.experiment.config.file import read_settings
from cardsflow_fmu.experiment.config.key_path import set_value
from cardsflow_fmu.experiment.config.multiples import require_multiple
from cardsflow_fmu.experiment.config.table import Context
from cardsflow_fmu.utils.multiples import MAX_STEPS, whole_duration
from sim_dart.plant.settings import require_rk4_support
from sim_dart.scene import Scene

from .config.custom_law import CustomLaw
from .loops import closing_dynamics, with_dependent, with_resting_points
from .motion.look_ahead import LOOK_AHEAD_FILE, read_look_ahead
from .motion.settings import FREE_STARTS, MotionTable, with_default_muscles
from .packed_files import (
    mesh_roots,
    named_files,
    require_archive_files,
    require_archive_paths,
    require_packable,
)
from .settings.controller import read_controller
from .settings.controller_types import DEFAULT_GAINS, FEEDBACK, POLICY, control_type
from .settings.estimator import EstimatorTable, read_estimator
from .settings.faults import FaultsTable, read_faults
from .settings.file import ExperimentTables
from .settings.hardware import HardwareSettings, read_hardware
from .settings.loads import complete_wiring, read_disturbance
from .settings.muscles import with_muscle_settings
from .settings.plant import PlantSettings, StartSettings
from .settings.predictive import MPC, require_bounds, require_predictable
from .settings.reference import ReferenceSettings
from .settings.robots import combine_robots, read_parts, read_robot, robot_names
from .settings.run import RunSettings
from .start import read_controller_gains, read_reference

EXPERIMENT_TOML = "experiment.toml"

_GAINS = dict(zip(("kp", "kd"), DEFAULT_GAINS, strict=True))


def read_experiment(
    path: Path, settings: Mapping[str, Any], *, names_files: bool
) -> dict[str, Any]:
    """Read and check an experiment.

    Args:
        path: An experiment.toml, its folder, or the experiment.json of an FMU.
        settings: Changes by full key.
        names_files: Whether files that the changes name may be packed from any folder.

    Raises:
        InputError: The experiment is invalid; the message names file and key.
    """
    data, file = _read_data(path, settings)
    named = named_files(settings, file.parent) if names_files else ()
    return experiment_settings(data, file, named)


def follows_motion(path: Path, settings: Mapping[str, Any]) -> bool:
    """Return whether a run of an experiment follows motion.csv with the feedback of the motion."""
    data = _follow_motion(_read_data(path, settings)[0])
    is_followed = data["controller"].get("type") == FEEDBACK
    return is_followed and data.get("reference") == {"type": "optimised"}


def _read_data(path: Path, settings: Mapping[str, Any]) -> tuple[dict[str, Any], Path]:
    """Return the content of an experiment with changes, and its file."""
    file = path / EXPERIMENT_TOML if path.is_dir() else path
    _require_experiment(path, file)
    _require_text(file)
    data = read_settings(file)
    for key, value in settings.items():
        set_value(data, key, value, file)
    return data, file


def read_packed_experiment(file: Path) -> dict[str, Any]:
    """Read and check an experiment in an unpacked archive with all its files.

    Raises:
        InputError: The experiment is invalid, or names files outside of the archive.
    """
    data = read_settings(file)
    require_archive_paths(data, file)
    settings = experiment_settings(data, file)
    for files in (settings["robot_files"], *(part.files for part in settings.get("parts", ()))):
        require_archive_files(files, file.parent)
    robot: Robot = settings["robot"]
    muscles = [robot.muscles[k].name for k in measured_muscles(robot)]
    return {**settings, "look_ahead": read_look_ahead(file.with_name(LOOK_AHEAD_FILE), muscles)}


def _require_experiment(path: Path, file: Path) -> None:
    """Reject a robot file with a hint how to create an experiment."""
    if path.suffix != ".toml" and holds_robot(path) and not (path.is_dir() and file.is_file()):
        robot = shlex.quote(str(path))
        problem = f"is a robot; create an experiment: `cardsflow init {robot} -o {EXPERIMENT_TOML}`"
        raise InputError(problem, file=path)


def _require_text(file: Path) -> None:
    """Check that the path of a file can be encoded in FMUs and HTML pages."""
    try:
        str(file.absolute()).encode()
    except UnicodeEncodeError:
        problem = f"its path is not valid {sys.getfilesystemencoding()}, the encoding of the system"
        raise InputError(f"{problem}: rename the folder, or change the locale", file=file) from None


def experiment_settings(
    data: Mapping[str, Any],
    file: Path,
    named: tuple[Path, ...] = (),
    reading: Reading | None = None,
) -> dict[str, Any]:
    """Return the attributes of an `Experiment` from the content of a file.

    Args:
        named: Files that may be packed from any folder.
        reading: Result of reading the robot of [robot], to read it only once.
    """
    context = Context(file)
    data = _add_default_gains(_follow_motion(data))
    tables = ExperimentTables.read(data, context)
    robots, in_file = _read_robots(tables, context, named, reading)
    robot = robots["robot"] = with_muscle_settings(robots["robot"], tables.muscles, context)
    data = with_dependent(data, robot, file)
    context = Context(file, robot_names(robot))
    mains = [robots["robot_path"], *(part.files[0] for part in robots.get("parts", ()))]
    roots = mesh_roots(file, mains, named)
    _require_packable_files(tables, robot, roots)
    start, reference = _read_motion(data, tables, context, robots, in_file)
    context = Context(file, robot_names(robot, reference.space))
    run = _read_run(tables.run, reference, context)
    folder = mains[0].parent
    world = _read_world(tables, robot, folder, roots, context) if data.get("world") else {}
    plant = _read_plant(data.get("plant", {}), context, robot, run, world.get("scene"))
    sensing = _read_sensing(data, tables, context, robot, folder, run)
    disturbance = read_disturbance(data.get("disturbance", {}), context)
    wiring = _estimator_wiring(robot, **sensing)
    wiring |= complete_wiring(tables.wiring, robot, disturbance, plant)
    controller = read_controller(data["controller"], context, run, reference.space, start)
    if controller.type == MPC:
        require_predictable(robot, plant, "scene" in world, controller.engine, context)
        require_bounds(controller.bounds, robot, context)
    controller, feedback = read_controller_gains(
        controller, tables.reference, reference, context, robot, roots
    )
    motion = data.get("motion") and with_default_muscles(data["motion"], robot)
    return {
        "file": file,
        **robots,
        "reference": reference,
        "feedback": feedback,
        "motion": None if motion is None else MotionTable.read(motion, context, "motion"),
        "disturbance": disturbance,
        "start": start,
        "plant": plant,
        "controller": controller,
        "run": run,
        "wiring": wiring,
        **sensing,
        "fmus": tables.fmus.by_role,
        **world,
        "about": tables.about,
        "named": named,
    }


def _require_packable_files(
    tables: ExperimentTables, robot: Robot, roots: tuple[Path, ...]
) -> None:
    """Check that the files of the reference and of custom muscle laws may be packed."""
    if tables.reference is not None and tables.reference.file is not None:
        require_packable(tables.reference.file, roots, "reference.file")
    for muscle in robot.muscles:
        if muscle.model.custom is not None:
            require_packable(Path(muscle.model.custom.file), roots, f"muscles.{muscle.name}.model")


def _read_motion(
    data: Mapping[str, Any],
    tables: ExperimentTables,
    context: Context,
    robots: Mapping[str, Any],
    in_file: list[str],
) -> tuple[StartSettings, ReferenceSettings]:
    """Read the initial state and the reference, in the space that the controller controls."""
    law, robot = tables.controller.type, robots["robot"]
    space = "joint" if law is None else control_type(law, tables.controller.custom_space).space
    return read_reference(
        with_resting_points(data, robot),
        data.get("start", {}),
        space,
        context,
        robots["robot_path"],
        robot,
        in_file,
        closing_dynamics(data, robot),
        has_free_start=bool(FREE_STARTS & set(data.get("motion") or {})),
    )


def _read_run(run: RunSettings, reference: ReferenceSettings, context: Context) -> RunSettings:
    """Return the run with its duration, which is a multiple of its step."""
    if run.duration is None:
        run = run.copy_with(duration=whole_duration(reference.duration, run.step))
    require_multiple(run.duration, run.step, "run.step", file=context.file, key="run.duration")
    return run


def _read_sensing(
    data: Mapping[str, Any],
    tables: ExperimentTables,
    context: Context,
    robot: Robot,
    folder: Path,
    run: RunSettings,
) -> dict[str, Any]:
    """Read hardware, estimator, and detection of faults; return them by attribute."""
    hardware = read_hardware(data.get("hardware", {}), context, run.step)
    calibrated = folder if tables.robots is None else None
    estimator = _read_estimator(data.get("estimator"), tables, context, robot, calibrated, run)
    if hardware.use and not hardware.has_positions:
        _require_estimate(estimator, context)
    faults = read_faults(data.get("faults"), context, estimator, run.step)
    return {"hardware": hardware, "estimator": estimator, "faults": faults}


def _read_estimator(
    data: Any,
    tables: ExperimentTables,
    context: Context,
    robot: Robot,
    folder: Path | None,
    run: RunSettings,
) -> EstimatorTable | None:
    """Return the estimator if it is used."""
    settings = None if data is None else read_estimator(data, context, robot, folder, run.step)
    if settings is not None and settings.use:
        return settings
    if tables.fmus.estimator is not None:
        problem = "requires an [estimator] with use = true"
        raise context.error("fmus.estimator", problem)
    return None


def _require_estimate(estimator: EstimatorTable | None, context: Context) -> None:
    """Check that an estimator replaces missing joint encoders of the hardware."""
    key = "hardware.has_positions"
    if estimator is None or not estimator.feedback:
        raise context.error(key, "false requires an [estimator] with feedback = true")
    if estimator.encoder_indices:
        problem = "false excludes encoders; remove estimator.encoder_noise"
        raise context.error(key, problem)


def _estimator_wiring(
    robot: Robot,
    hardware: HardwareSettings,
    estimator: EstimatorTable | None,
    faults: FaultsTable | None,
) -> dict[str, str | float]:
    """Return the connections of the estimator; none without an estimator."""
    if estimator is None:
        return {}
    return dict(
        estimation_wiring(
            robot,
            estimator.encoder_indices,
            uses_estimate=estimator.feedback,
            has_hardware=hardware.use,
            has_tensions=hardware.has_tensions,
            has_faults=faults is not None,
        )
    )


def _follow_motion(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the data with the optimal motion and its feedback if there is no controller."""
    if "motion" not in data or "controller" in data:
        return data
    return {"reference": {"type": "optimised"}, **data, "controller": {"type": FEEDBACK}}


def _add_default_gains(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the data with default gains for controllers that may not use them."""
    controller, fmus = data.get("controller", {}), data.get("fmus")
    if not isinstance(controller, Mapping):
        return data
    law = controller.get("type")
    has_no_law = law in (FEEDBACK, POLICY)
    has_any_gains = isinstance(law, str) and (has_no_law or CustomLaw.of(law) is not None)
    if not has_any_gains and not (isinstance(fmus, Mapping) and "controller" in fmus):
        return data
    return {**data, "controller": {**_GAINS, **controller}}


def _read_robots(
    tables: ExperimentTables, context: Context, named: tuple[Path, ...], reading: Reading | None
) -> tuple[dict[str, Any], list[str]]:
    """Read [robot], or combine [[robots]].

    Returns:
        Attributes of the `Experiment`, and the names of all coordinates in the robot file.
    """
    if tables.robots is None:
        reading, robot = read_robot(tables.robot, context, reading=reading)
        fields: dict[str, Any] = {"robot_overrides": tables.robot.overrides}
    else:
        fields = {"parts": read_parts(tables.robots, context)}
        reading, robot = combine_robots(fields["parts"], context, named)
    fields |= {"robot": robot, "robot_path": reading.files[0], "robot_files": reading.files}
    return fields, [] if tables.robot is None else [c.name for c in reading.require().coordinates]


def _read_world(
    tables: ExperimentTables,
    robot: Robot,
    folder: Path,
    roots: tuple[Path, ...],
    context: Context,
) -> dict[str, Any]:
    from .scene import make_scene  # imports DART, which is only required for scenes

    scene, world, findings = make_scene(tables.world, robot, folder.resolve(), roots, context)
    return {"scene": scene, "world": world, "world_findings": findings}


def _read_plant(
    data: Mapping[str, Any], context: Context, robot: Robot, run: RunSettings, scene: Scene | None
) -> PlantSettings:
    settings = PlantSettings.read({"step": run.step, **data}, context, "plant")
    links = [link.name for link in robot.links]
    for name in settings.wrenches:
        context.require("plant.wrenches", "link", name, links)
    shared = set(load_signals(robot)).intersection(wrench_signals(settings.wrenches))
    if shared:
        problem = f"{sorted(shared)[0]!r} is also the force on an end-effector point; rename one"
        raise context.error("plant.wrenches", problem)
    if settings.integrator == "rk4":
        try:
            require_rk4_support(settings.engine, scene, robot)
        except InputError as error:
            raise context.error("plant.integrator", str(error)) from None
    if settings.engine == "core" and scene is not None:
        raise context.error("plant.engine", '"core" does not support contacts; use "dart"')
    require_multiple(
        run.step,
        settings.step,
        "plant.step",
        file=context.file,
        key="plant.step",
        blame="run.step",
        most=MAX_STEPS,
    )
    return settings
