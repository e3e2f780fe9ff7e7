"""Compilation of a model by MuJoCo in a separate process.

MuJoCo is written in C++, and the files are untrusted: a crash or excessive use of memory or time
ends only that process. The process receives one text without includes and the paths of the meshes.
All of them are checked before; see `document.py`.
"""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from ...errors import InputError
from ...json_text import json_text
from ...limits import MIB, MJCF_MEMORY, MJCF_SECONDS, MUSCLES_WITHOUT_RANGE
from ...model.pose import Vector3
from ...model.rotations import Matrix3, quaternion_rotation
from ...model.transform import IDENTITY, Transform
from .document import Document

MUJOCO_MISSING = (
    "MuJoCo is required to read MJCF, but is not installed; run pip install 'cardsflow[mujoco]'"
)
MAX_RUN_TIME = 60.0
"""Maximum run time of the compiler on a busy machine, in [s]; processor time is limited too."""

Row = dict[str, Any]
"""Element of the compiled model: its `name`, its `line`, and fields of mjModel."""

_PROGRAM = Path(__file__).with_name("compiler.py")
_QUIET = {"MUJOCO_GL": "disable", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
_LINE = re.compile(r"line (\d+)\s*$")
_ELEMENT = re.compile(r"\nElement .*$", re.DOTALL)
_MAX_MESSAGE = 300
_OUT_OF_TIME = -getattr(signal, "SIGXCPU", sys.maxsize)
"""Exit code of a process that exceeds its limit of processor time."""


class Compiled:
    """Compiled MuJoCo model.

    Attributes:
        bodies, joints, geoms, sites, tendons, equalities, actuators: Rows in MuJoCo's order.
        dofs, wraps: Rows without names.
        meshes: Rows of the compiled meshes, by name.
        scales: Scales of all meshes, by name.
        read: Keys of the mesh files that MuJoCo opened.
        qpos0, qpos_spring: Reference pose, and reference pose of the springs.
        initial: Values of the keyframe `initial`, or None.
        option: Gravity, fluid, and disabled features.
    """

    def __init__(self, answer: Mapping[str, Any]) -> None:
        tables: dict[str, list[Row]] = answer["tables"]
        self.bodies, self.joints, self.dofs = tables["body"], tables["jnt"], tables["dof"]
        self.geoms, self.sites = tables["geom"], tables["site"]
        self.tendons, self.wraps = tables["tendon"], tables["wrap"]
        self.equalities, self.actuators = tables["eq"], tables["actuator"]
        self.meshes = {row["name"]: row for row in tables["mesh"]}
        self.scales: dict[str, list[float]] = answer["scales"]
        self.read: list[str] = answer["read"]
        self.qpos0: list[float] = answer["qpos0"]
        self.qpos_spring: list[float] = answer["qpos_spring"]
        self.initial: list[float] | None = answer["initial"]
        self.option: Row = answer["option"]
        for row in self.actuators:
            first = row["ctrladr"]
            limited = row["ctrlnum"] and answer["ctrllimited"][first]
            row["ctrlrange"] = tuple(answer["ctrlrange"][first]) if limited else None


def compile_document(document: Document) -> Compiled | None:
    """Return the compiled model, or None with a recorded error if MuJoCo rejects it.

    Raises:
        InputError: MuJoCo is not installed, or crashes on the file.
    """
    if find_spec("mujoco") is None:
        raise InputError(MUJOCO_MISSING, file=document.root.file)
    text = document.text()
    files = {key: os.fspath(file) for key, file in document.mesh_files.items()}
    request = {
        "xml": text,
        "meshes": files,
        "places": MUSCLES_WITHOUT_RANGE,
        "memory": MJCF_MEMORY,
        "seconds": MJCF_SECONDS,
    }
    answer = run_compiler(request, document.root.file)
    if "error" in answer:
        _report_rejection(document, answer["error"])
        return None
    for warning in answer["warnings"]:
        document.root.warning("mujoco-warns", f"MuJoCo: {_single_line(warning)}")
    return Compiled(answer)


def run_compiler(request: Mapping[str, Any], file: Path) -> dict[str, Any]:
    """Send a request to the compiler process and return its answer; see `compiler.answer`.

    Raises:
        InputError: The process crashes, or exceeds its limit of time or memory.
    """
    command = [sys.executable, "-P", str(_PROGRAM)]
    data = json_text(request).encode()
    # Libraries of sanitizers and profilers reserve more memory than the compiler is allowed.
    environment = {k: v for k, v in os.environ.items() if k != "LD_PRELOAD"} | _QUIET
    try:
        done = subprocess.run(
            command, input=data, capture_output=True, timeout=MAX_RUN_TIME, env=environment
        )
    except subprocess.TimeoutExpired:
        raise InputError(f"compilation in MuJoCo exceeds {MAX_RUN_TIME:g} s", file=file) from None
    except OSError as error:
        problem = f"the MuJoCo compiler cannot be started: {error.strerror or error}"
        raise InputError(problem, file=file) from error
    if done.returncode == 0 and done.stdout:
        answer: dict[str, Any] = json.loads(done.stdout)
        return answer
    raise InputError(_failure(done.returncode, done.stderr.decode(errors="replace")), file=file)


def _failure(code: int, output: str) -> str:
    """Return the reason why the compiler ended without an answer."""
    if code == _OUT_OF_TIME:
        return f"compilation in MuJoCo exceeds {MJCF_SECONDS:g} s of processor time"
    if "MemoryError" in output or "bad_alloc" in output or "allocate" in output:
        return f"compilation in MuJoCo exceeds {MJCF_MEMORY // MIB} MiB of memory"
    last = (output.strip().splitlines() or [""])[-1]
    return f"MuJoCo crashes on this file: {_single_line(last) or f'exit code {code}'}"


def _report_rejection(document: Document, error: str) -> None:
    """Record an error of MuJoCo at the element on the line that the error names."""
    line = _LINE.search(error)
    problem = document.with_files(_ELEMENT.sub("", error).removeprefix("XML "))
    problem = problem.removeprefix("Error: ").removeprefix("Error: ")  # may be repeated
    node = document.node_at(int(line[1])) if line else document.root
    named = node.element.get("name")
    which = f"<{node.tag}>" + (f" {named[:40]!r}" if named else "")
    node.error("mujoco-refuses", f"MuJoCo rejects {which}: {_single_line(problem)}")


def _single_line(text: str) -> str:
    return " ".join(text.split())[:_MAX_MESSAGE]


def transform(row: Row) -> Transform:
    """Return the pose of an element as a transform."""
    return Transform(rotation_of(row["quat"]), vector(row["pos"]))


def vector(values: list[float]) -> Vector3:
    """Return the first three numbers as a vector."""
    x, y, z = values[:3]
    return x, y, z


def rotation_of(q: list[float]) -> Matrix3:
    """Return the rotation of a unit quaternion w, x, y, z."""
    w, x, y, z = q
    if (x, y, z) == (0.0, 0.0, 0.0):
        return IDENTITY.R
    return quaternion_rotation(w, x, y, z)
