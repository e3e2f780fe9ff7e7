"""Writer for example.h: robot and settings of an example as constant data in C."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from cardsflow_fmu import Experiment
from cardsflow_fmu.models.reference import make_reference
from controllers.qp.dual_newton import library
from sim_dart import compile_blob
from sim_dart.core.library import library as core_library
from sim_dart.core.supported_features import used_parts
from sim_dart.core.tasks import task_rows

from .vector_file import law_arrays


def write_example(path: Path, experiment: Experiment, *, single: bool = False) -> int:
    """Write example.h for a precision, and parts.h; return the size of the robot's blob, in bytes.

    The memory is sized for doubles and for the pointers of this machine, so it is sufficient.
    """
    robot, settings = experiment.robot, experiment.controller
    blob = compile_blob(robot, single=single)
    rows = [] if settings.space == "joint" else task_rows(robot)
    n, m = len(robot.coordinates), len(robot.muscles)
    words = np.frombuffer(blob, "<u8")
    reference = np.array(make_reference(experiment).evaluate(0.5)[:3])
    arrays = {name: np.ravel(values) for name, values in law_arrays(experiment).items()}
    lines = [
        '#include "sim_dart/csrc/numbers/real.h"',
        "#include <stddef.h>",
        "#include <stdint.h>",
        f"enum {{ COORDINATES = {n}, MUSCLES = {m}, TASKS = {len(rows)} }};",
        f"enum {{ ROBOT_MEMORY = {_core_size(compile_blob(robot))} }};",
        f"enum {{ LOOP_MEMORY = {_loop_size(n, m, len(rows))} }};",
        f"static const uint64_t BLOB[] = {{{', '.join(f'{word}u' for word in words)}}};",
        _array("TASK_ROWS", [*rows, 0.0]),
        _array("START", experiment.start.q),
        _array("REFERENCE", np.ravel(reference)),
        f"enum {{ PLANT_STEPS = {round(settings.period / experiment.plant.step)} }};",
        f"static const real PLANT_STEP = {experiment.plant.step.hex()};",
        f"static const real PERIOD = {float(settings.period).hex()};",
        *(_array(_identifier(name), values) for name, values in arrays.items()),
        "static const struct { const char *name; const real *values; size_t count; }",
        "SETTINGS[] = {",
        *(f'{{"{name}", {_identifier(name)}, {len(a)}}},' for name, a in arrays.items()),
        "};",
    ]
    path.write_text("\n".join(lines) + "\n")
    parts = used_parts(robot) + ["USES_TASKS"] * (len(rows) > 0)
    parts += ["USES_NORMS"] * (settings.norm != 2.0)
    (path.parent / "parts.h").write_text("".join(f"#define {part} 1\n" for part in parts))
    return len(blob)


def _core_size(blob: bytes) -> int:
    """Return the size on this machine, whose pointers are at least as large, in bytes."""
    words = np.frombuffer(blob, np.float64)
    return -(-int(core_library().core_size(words.ctypes.data, len(blob), None, 0)) // 8) * 8


def _loop_size(n: int, m: int, k: int) -> int:
    size = library().control_loop_size
    return -(-int(size(n, m, k)) // 8) * 8


def _identifier(name: str) -> str:
    return f"LAW_{name.upper()}"


def _array(name: str, values: ArrayLike) -> str:
    """Return a constant array in C, as hexadecimal floats, which are exact."""
    numbers = [_number(float(value)) for value in np.ravel(np.asarray(values, float))]
    return f"static const real {name}[] = {{{', '.join(numbers)}}};"


def _number(value: float) -> str:
    if np.isinf(value):
        return "-__builtin_inf()" if value < 0 else "__builtin_inf()"
    return value.hex()
