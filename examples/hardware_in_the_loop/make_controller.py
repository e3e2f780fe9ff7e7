"""Write the input of controller.c for an experiment: robot.h, and the reference of every tick.

    python make_controller.py ../planar_2r build [--single] [--set KEY=VALUE ...]

robot.h contains robot, settings and signature as constant data; parts.h lists the parts of the C
core that the controller uses; reference.f64 contains position, velocity and acceleration of every
tick, as doubles. With --single the law computes in single precision, for a microcontroller whose
floating point unit supports no other.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment
from cardsflow_fmu.cli.common import parse_settings
from cardsflow_fmu.experiment.settings.predictive import MPC
from cardsflow_fmu.hardware.protocol.handshake import split_uint64
from cardsflow_fmu.hardware.protocol.signals import hardware_signature
from cardsflow_fmu.models.estimator import make_estimator
from cardsflow_fmu.models.reference import make_reference
from controllers.qp.dual_newton import library as laws
from sim_dart import compile_blob
from sim_dart.core.library import library as core
from sim_dart.core.supported_features import used_parts
from sim_dart.core.tasks import task_rows
from sim_dart.estimation.estimated_robot import estimated_robot
from sim_dart.muscles.friction import has_cable_friction

OF_ESTIMATOR = (
    *("length_noise", "encoder_noise", "compliance", "offset", "slack", "gate"),
    *("acceleration_noise", "load_drift", "search", "starts", "start", "start_low", "start_high"),
    *("start_sd", "largest_sd", "largest_innovation", "innovation_time"),
)
"""Settings of the estimator in C, by the names of estimator.h."""


def law_settings(experiment: Experiment) -> dict[str, ArrayLike]:
    """Return the law settings, by `law.` and the names of control_loop.h and computed_torque.h."""
    robot, settings = experiment.robot, experiment.controller
    arrays = settings.law_arrays() | {
        "f_min": [muscle.f_min for muscle in robot.muscles],
        "f_max": [muscle.f_max for muscle in robot.muscles],
        "q_min": [c.lower for c in robot.coordinates],
        "q_max": [c.upper for c in robot.coordinates],
        "gain": -np.expm1(-settings.observer * settings.period),
    }
    return {f"law.{name}": values for name, values in arrays.items()}


def header(experiment: Experiment, arrays: Mapping[str, ArrayLike], single: bool) -> str:
    """Return the text of robot.h."""
    robot, blob = experiment.robot, compile_blob(experiment.robot)
    robot_data = compile_blob(robot, single=True) if single else blob
    rows = [] if experiment.controller.space == "joint" else task_rows(robot)
    n, m, words = len(robot.coordinates), len(robot.muscles), np.frombuffer(robot_data, "<u8")
    robot_size = core().core_size(np.frombuffer(blob).ctypes.data, len(blob), None, 0)
    high, low = split_uint64(hardware_signature(robot, experiment.hardware))
    lines = [
        f"/* {robot.name}: written by make_controller.py */",
        "#include <math.h>",
        "#include <stddef.h>",
        "#include <stdint.h>",
        f"enum {{ COORDINATES = {n}, MUSCLES = {m}, TASKS = {len(rows)} }};",
        f"enum {{ ROBOT_MEMORY = {whole_words(robot_size)} }};",
        f"enum {{ LOOP_MEMORY = {whole_words(laws().control_loop_size(n, m, len(rows)))} }};",
        f"static const uint64_t BLOB[] = {{{', '.join(f'{word}u' for word in words)}}};",
        f"static const double SIGNATURE_HIGH = {high:.0f}, SIGNATURE_LOW = {low:.0f};",
        f"static const double STEP = {float(experiment.run.step).hex()}L;",  # stays a double
        array("START", experiment.start.q, "double"),
        array("F_MIN", [muscle.f_min for muscle in robot.muscles], "double"),
        array("TASK_ROWS", [*rows, 0.0]),
        *table("SETTINGS", arrays, "law."),
        *estimator_lines(experiment, single),
    ]
    return "\n".join(lines) + "\n"


def parts(experiment: Experiment) -> str:
    """Return the text of parts.h, for `-DCARDSFLOW_PARTS`."""
    names = {*used_parts(experiment.robot)}
    if experiment.estimator is not None:
        names |= {*used_parts(estimated_robot(experiment.robot))}
    if experiment.controller.space == "operational":
        names.add("USES_TASKS")
    if experiment.controller.norm != 2.0:
        names.add("USES_NORMS")
    return "".join(f"#define {name} 1\n" for name in sorted(names))


def estimator_lines(experiment: Experiment, single: bool) -> list[str]:
    """Return the lines of robot.h for the estimator."""
    settings = experiment.estimator
    if settings is None:
        return ["#define ESTIMATED 0"]
    estimator, robot = make_estimator(experiment), estimated_robot(experiment.robot)
    blob = compile_blob(robot)
    words = np.frombuffer(compile_blob(robot, single=True) if single else blob, "<u8")
    size = core().core_size(np.frombuffer(blob).ctypes.data, len(blob), None, 0)
    encoded = [float(j in settings.encoder_indices) for j in range(len(robot.coordinates))]
    offsets = len(estimator.offset_changes)
    names = (*OF_ESTIMATOR, *(("offset_drift", "start_offset_sd") if offsets else ()))
    arrays = {f"observer.{name}": estimator.array(name, -1) for name in names}
    return [
        "#define ESTIMATED 1",
        f"enum {{ OFFSETS = {offsets} }};",
        f"enum {{ OBSERVED_MEMORY = {whole_words(size)} }};",
        f"enum {{ OBSERVER_MEMORY = {whole_words(estimator.size)} }};",
        f"static const uint64_t OBSERVED[] = {{{', '.join(f'{word}u' for word in words)}}};",
        array("ENCODED", encoded),
        *table("OBSERVER_SETTINGS", arrays, "observer."),
    ]


def table(title: str, arrays: Mapping[str, ArrayLike], prefix: str = "") -> list[str]:
    """Return constant C arrays, and a table of them by name, without the prefix."""
    flat = {name: np.ravel(np.asarray(values, float)) for name, values in arrays.items()}
    return [
        *(array(identifier(name), values) for name, values in flat.items()),
        "static const struct { const char *name; const real *values; size_t count; }",
        f"{title}[] = {{",
        *(
            f'{{"{name.removeprefix(prefix)}", {identifier(name)}, {len(values)}}},'
            for name, values in flat.items()
        ),
        "};",
    ]


def whole_words(size: int) -> int:
    """Return a size in [byte], rounded up to a multiple of 8."""
    return -(-int(size) // 8) * 8


def identifier(name: str) -> str:
    """Return the name in C, such as LAW_KP for law.kp."""
    return name.replace(".", "_").upper()


def array(name: str, values: ArrayLike, kind: str = "real") -> str:
    """Return a constant C array of hexadecimal floats, which are exact."""
    texts = [number(float(value)) for value in np.ravel(np.asarray(values, float))]
    return f"static const {kind} {name}[] = {{{', '.join(texts)}}};"


def number(value: float) -> str:
    """Return a number in C."""
    return value.hex() if np.isfinite(value) else "-HUGE_VAL" if value < 0 else "HUGE_VAL"


def write_controller(experiment: Experiment, folder: Path, *, single: bool = False) -> None:
    """Write robot.h, parts.h and reference.f64.

    Args:
        experiment: The experiment; its controller period is the step of the run.
        folder: The folder; created if it does not exist.
        single: Whether the law is compiled for single precision.

    Raises:
        InputError: controller.c does not support the experiment.
    """
    frames = experiment.robot.task_frames if experiment.controller.tasks else ()
    if experiment.controller.period != experiment.run.step:
        raise InputError("controller.c sends at every tick: set run.step to controller.period")
    if experiment.robot.loops:
        raise InputError("controller.c does not support closed loops")
    if has_cable_friction(experiment.robot):
        raise InputError("controller.c does not support cable friction")
    if experiment.robot.motors:
        raise InputError("controller.c commands muscles, not motors at joints")
    if experiment.controller.custom_law is not None:
        raise InputError("controller.c does not run Python: set controller.type to a built-in law")
    if experiment.controller.type == MPC:
        raise InputError(
            "controller.c has no predictive control: use controller.fmu, or another law"
        )
    if any(frame.is_orientation for frame in frames):
        raise InputError("controller.c does not support orientations, only points")
    if not experiment.hardware.has_positions:
        raise InputError("controller.c expects positions and velocities of the device")
    if not (experiment.hardware.has_lengths and experiment.hardware.has_tensions):
        raise InputError("controller.c expects lengths and tensions of the device")
    if experiment.hardware.motors.command != "force" or experiment.hardware.scale != 1.0:
        raise InputError("controller.c commands forces, in SI units")
    estimator = experiment.estimator
    if estimator is not None and (estimator.imus or estimator.delay(experiment.run.step)):
        raise InputError("controller.c supports no IMUs and no delayed measurements")
    if estimator is not None and estimator.type == "horizon":
        raise InputError('controller.c has no horizon: set estimator.type = "kalman"')
    if estimator is not None and estimator.estimator_settings.exact_transition:
        raise InputError("controller.c has no derivatives: set estimator.exact_transition = false")
    times = np.arange(experiment.run.steps) * experiment.run.step
    ticks = np.stack(make_reference(experiment).evaluate(times), axis=1)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.h").write_text(header(experiment, law_settings(experiment), single))
    (folder / "parts.h").write_text(parts(experiment))
    (folder / "reference.f64").write_bytes(ticks.astype("<f8").tobytes())


def main() -> None:
    """Run with the arguments of the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("experiment", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--single", action="store_true", help="for a law of single precision")
    options = parser.parse_args()
    experiment = Experiment.load(options.experiment, parse_settings(options.set))
    write_controller(experiment, options.folder, single=options.single)
    print(f"signature {hardware_signature(experiment.robot, experiment.hardware):016x}")
    print(f"start     {','.join(map(repr, experiment.start.q))}")


if __name__ == "__main__":
    main()
