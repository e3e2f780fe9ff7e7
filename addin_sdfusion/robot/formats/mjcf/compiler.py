"""MuJoCo's compiler as a separate program: reads a request on stdin, writes the model to stdout.

The program is started by its path. It imports nothing from this package, and this package never
imports MuJoCo. It limits its memory and time, opens no files after the required meshes, and writes
no files. Request and answer are JSON; `compiled.py` starts the program and reads the answer.
"""

from __future__ import annotations

import json
import math
import os
import signal
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np

try:
    import resource
except ImportError:  # on Windows only the time limit of the parent applies
    resource = None  # type: ignore[assignment]

Request = Mapping[str, Any]
Answer = dict[str, Any]

POINT = 1e-3
"""Radius in [m] of the massless sphere that replaces a geom that MuJoCo need not compile."""
GRID, SWEEPS = 6, 2
"""Values per joint in the search for lengths, and coarse and fine sweeps over the joints."""

FIELDS = {
    "body": "parentid pos quat mass ipos iquat inertia gravcomp mocapid",
    "jnt": "type bodyid pos axis limited range stiffness stiffnesspoly springyield "
    "actfrclimited actfrcrange qposadr dofadr",
    "dof": "damping dampingpoly armature frictionloss",
    "geom": "type bodyid pos quat size group dataid",
    "site": "bodyid pos quat",
    "mesh": "pos quat",
    "tendon": "adr num length0 stiffness stiffnesspoly damping dampingpoly frictionloss armature "
    "limited lengthspring springyield actfrclimited",
    "wrap": "type objid prm",
    "eq": "type obj1id obj2id objtype active0 data",
    "actuator": "trntype trnid gear gaintype gainprm biastype biasprm dyntype dynprm ctrladr "
    "ctrlnum forcelimited forcerange lengthrange acc0 armature damping delay",
}
"""Fields of mjModel to return for each kind of element, without the prefix of the kind."""
ENUMERATIONS = {
    "jnt_type": mujoco.mjtJoint,
    "geom_type": mujoco.mjtGeom,
    "wrap_type": mujoco.mjtWrap,
    "eq_type": mujoco.mjtEq,
    "eq_objtype": mujoco.mjtObj,
    "actuator_trntype": mujoco.mjtTrn,
    "actuator_gaintype": mujoco.mjtGain,
    "actuator_biastype": mujoco.mjtBias,
    "actuator_dyntype": mujoco.mjtDyn,
}
"""Fields whose values are returned as words, such as `hinge` for mjJNT_HINGE."""


def limit_resources(memory: int, seconds: float) -> None:
    """Set operating system limits on memory and processor time of this process.

    Args:
        memory: Maximum address space, in bytes.
        seconds: Maximum processor time, in [s].
    """
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # so that Ctrl-C also works inside MuJoCo
    if resource is not None:
        _limit(resource.RLIMIT_AS, memory)
        _limit(resource.RLIMIT_CPU, math.ceil(seconds), grace=1)  # SIGXCPU, then SIGKILL
        _limit(resource.RLIMIT_CORE, 0)
        _limit(resource.RLIMIT_FSIZE, 0)


def close_files() -> None:
    """Forbid opening further files."""
    if resource is not None:
        _limit(resource.RLIMIT_NOFILE, 0)


def _limit(kind: int, value: int, grace: int = 0) -> None:
    hard = resource.getrlimit(kind)[1]
    limit = value + grace if hard == resource.RLIM_INFINITY else min(value + grace, hard)
    with suppress(ValueError, OSError):  # not all systems support all limits
        resource.setrlimit(kind, (min(value, limit), limit))


def answer(request: Request, opened: Callable[[], None] = lambda: None) -> Answer:
    """Return the compiled model, or the error if MuJoCo rejects the model.

    Args:
        request: `xml`: the model as one text; `meshes`: the path of each mesh file in it;
            `places`: maximum number of body placements in the search for lengths.
        opened: Called when all required files are read.
    """
    messages: list[str] = []
    mujoco.set_mju_user_warning(messages.append)
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            tables = _compile(request, opened)
    except (ValueError, mujoco.FatalError) as error:
        return {"error": str(error)}
    except MemoryError:
        return {"error": "the model needs too much memory"}
    return tables | {"warnings": [*messages, *(str(item.message) for item in caught)]}


def _compile(request: Request, opened: Callable[[], None]) -> Answer:
    spec = mujoco.MjSpec.from_string(request["xml"])
    # By default MuJoCo finds length ranges by a simulation, which is not reproducible.
    spec.compiler.LRopt.mode = mujoco.mjtLRMode.mjLRMODE_NONE
    spec.compiler.fusestatic = spec.compiler.discardvisual = spec.compiler.usethread = False
    replaced = _replace_geoms(spec, request["meshes"])
    needed = {g.meshname for g in [*spec.geoms, *spec.sites] if g.meshname}
    scales = {mesh.name: mesh.scale.tolist() for mesh in spec.meshes}
    for mesh in [mesh for mesh in spec.meshes if mesh.file]:
        if mesh.name in needed and mesh.file in request["meshes"]:
            spec.assets[mesh.file] = Path(request["meshes"][mesh.file]).read_bytes()
        elif mesh.name not in needed:
            spec.delete(mesh)
    opened()
    read = list(spec.assets)
    model = spec.compile()
    tables = {
        kind: _table(model, kind, fields.split(), elements)
        for (kind, fields), elements in zip(FIELDS.items(), _elements(spec), strict=True)
    }
    for geom, mesh, is_missing in replaced:
        tables["geom"][geom.id] |= {"type": "mesh", "mesh": mesh, "missing": is_missing}
    lengths = _find_lengths(model, request["places"])
    for row, length in zip(tables["actuator"], lengths, strict=True):
        row["foundrange"] = length
    keys = [key for key in range(model.nkey) if model.key(key).name == "initial"]
    return {
        "tables": tables,
        "scales": scales,
        "read": read,
        "qpos0": model.qpos0.tolist(),
        "qpos_spring": model.qpos_spring.tolist(),
        "initial": model.key_qpos[keys[0]].tolist() if keys else None,
        "ctrlrange": model.actuator_ctrlrange.tolist(),
        "ctrllimited": model.actuator_ctrllimited.tolist(),
        "option": _option(model.opt),
    }


class ReplacedGeom(NamedTuple):
    """Geom with a mesh that is only drawn, or missing; it is compiled as a point."""

    geom: Any
    mesh: str
    is_missing: bool


def _replace_geoms(spec: Any, files: Mapping[str, str]) -> list[ReplacedGeom]:
    """Replace geoms whose meshes MuJoCo does not need or cannot read by points."""
    of_files = {mesh.name: mesh.file for mesh in spec.meshes if mesh.file}
    replaced = []
    for geom in spec.geoms:
        counts, mesh, mass = _has_mass(spec, geom), geom.meshname, 0.0
        geom.contype = geom.conaffinity = 0  # avoids convex hulls for contacts
        is_drawn = geom.type == mujoco.mjtGeom.mjGEOM_MESH and not counts
        is_missing = mesh in of_files and of_files[mesh] not in files
        if mesh in of_files and (is_drawn or is_missing):
            replaced.append(ReplacedGeom(geom, mesh, is_missing and counts))
            # A moving body needs mass here; its missing mesh is reported later.
            mass = float(is_missing and counts and _moves(geom.parent))
        elif geom.type != mujoco.mjtGeom.mjGEOM_HFIELD:
            continue
        geom.type, geom.meshname, geom.hfieldname = mujoco.mjtGeom.mjGEOM_SPHERE, "", ""
        geom.size, geom.mass, geom.fromto = [POINT, 0.0, 0.0], mass, [math.nan] * 6
    return replaced


def _moves(body: Any) -> bool:
    """Return whether a body moves; MuJoCo rejects moving bodies without mass."""
    while body is not None and body.name != "world":
        if body.joints:
            return True
        body = body.parent
    return False


def _has_mass(spec: Any, geom: Any) -> bool:
    """Return whether a geom contributes to the mass of its body."""
    first, last = spec.compiler.inertiagrouprange
    from_geoms, body = spec.compiler.inertiafromgeom, geom.parent
    if from_geoms == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_AUTO:
        is_asked = not body.explicitinertial
    else:
        is_asked = from_geoms == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    is_heavy = geom.density != 0.0 if math.isnan(geom.mass) else geom.mass != 0.0
    return is_asked and is_heavy and first <= geom.group <= last and body.name != "world"


def _elements(spec: Any) -> Iterator[Sequence[Any]]:
    """Yield the elements of each kind in `FIELDS`, in the order of mjModel."""
    kinds = (spec.bodies, spec.joints, (), spec.geoms, spec.sites, spec.meshes, spec.tendons, (),
             spec.equalities, spec.actuators)  # fmt: skip
    for elements in kinds:
        yield sorted(elements, key=lambda item: item.id)


def _table(model: Any, kind: str, fields: Sequence[str], elements: Sequence[Any]) -> list[Answer]:
    """Return a row for each element: its fields, and its name and line if they exist."""
    columns = {}
    for field in fields:
        name = f"{kind}_{field}"
        values = getattr(model, name).tolist()
        words = ENUMERATIONS.get(name)
        columns[field] = (
            values if words is None else [_enumerator_word(words(v).name) for v in values]
        )
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    for row, element in zip(rows, elements, strict=False):
        row |= {"name": element.name, "line": _line(element.info)}
    for row in rows if kind == "geom" else ():
        is_mesh = row["type"] == "mesh" and row["dataid"] >= 0
        row["mesh"] = model.mesh(row["dataid"]).name if is_mesh else ""
    return rows


def _enumerator_word(name: str) -> str:
    """Return the word of an enumerator, such as `hinge` for mjJNT_HINGE."""
    return name.partition("_")[2].lower()


def _line(info: str) -> int:
    """Return the line of an element in the text of the request; 0 if unknown."""
    number = info.rpartition("line ")[2]
    return int(number) if number.isdigit() else 0


def _option(option: Any) -> Answer:
    disabled = [
        _enumerator_word(name)
        for name, bit in mujoco.mjtDisableBit.__members__.items()
        if name != "mjNDISABLE" and option.disableflags & bit.value
    ]
    return {
        "gravity": option.gravity.tolist(),
        "density": option.density,
        "viscosity": option.viscosity,
        "wind": option.wind.tolist(),
        "disabled": disabled,
        "disabled_groups": option.disableactuator,
    }


def _find_lengths(model: Any, places: int) -> list[list[float] | None]:
    """Return the minimum and maximum length of each muscle without a range, in [m] or [rad].

    All other actuators get None. The limits of the tendon replace a search over joints without
    ranges, or one that needs too many placements; without such limits, the muscle gets None.
    """
    ranges: list[list[float] | None] = [None] * len(model.actuator_trntype)
    search: _LengthSearch | None = None
    for k in range(len(ranges)):
        low, high = model.actuator_lengthrange[k]
        is_muscle = model.actuator_gaintype[k] == mujoco.mjtGain.mjGAIN_MUSCLE
        if is_muscle and not low < high and model.actuator_gear[k][0] > 0.0:
            search = search or _LengthSearch(model)
            due = search.placements(k)
            if due <= places:
                places -= due
                ranges[k] = search.range_of(k)
            tendon = model.actuator_trnid[k][0]
            on_tendon = model.actuator_trntype[k] == mujoco.mjtTrn.mjTRN_TENDON
            if ranges[k] is None and on_tendon and model.tendon_limited[tendon]:
                ranges[k] = model.tendon_range[tendon].tolist()
    return ranges


class _LengthSearch:
    """Search for muscle lengths over the joint ranges; coupled joints follow their leaders."""

    def __init__(self, model: Any) -> None:
        self._model, self._data = model, mujoco.MjData(model)
        self._followers = self._coupled_joints()

    def placements(self, actuator: int) -> int:
        """Return the number of bodies that `range_of` places."""
        count = max(len(self._joints_of_target(actuator)), 1)
        return int(2 * 2 * SWEEPS * count * GRID * self._model.nbody)

    def range_of(self, actuator: int) -> list[float] | None:
        """Return the minimum and maximum length; None if a joint that changes it has no range."""
        joints = self._joints_of_target(actuator)
        on_path = self._is_spatial(actuator)
        ranges = [self._ends(joint, on_path) for joint in joints]
        if not np.isfinite(ranges).all():
            return None
        address = self._model.jnt_qposadr[joints]
        ends = []
        for sign in (1.0, -1.0):
            best_q = self._model.qpos0.copy()
            best = sign * self._length(actuator, best_q)
            for sweep in range(2 * SWEEPS):
                for k, (lower, upper) in enumerate(ranges):
                    width = (upper - lower) / (GRID - 1) / (1.0 if sweep < SWEEPS else GRID)
                    middle = 0.5 * (lower + upper) if sweep < SWEEPS else best_q[address[k]]
                    for j in range(GRID):
                        at = middle + (j - (GRID - 1) / 2.0) * width
                        q = best_q.copy()
                        q[address[k]] = min(max(at, lower), upper)
                        value = sign * self._length(actuator, q)
                        if value < best:
                            best, best_q = value, q
            ends.append(sign * best)
        return ends if ends[0] < ends[1] else None

    def _length(self, actuator: int, q: Any) -> float:
        """Return the length of the target of an actuator, without its gear."""
        for first, second, powers in self._followers:
            x = 0.0 if second < 0 else q[second] - self._model.qpos0[second]
            moved = sum(c * x**k for k, c in enumerate(powers))
            q[first] = self._model.qpos0[first] + moved
        self._data.qpos[:] = q
        for step in (
            mujoco.mj_kinematics,
            mujoco.mj_comPos,
            mujoco.mj_tendon,
            mujoco.mj_transmission,
        ):
            step(self._model, self._data)
        return float(self._data.actuator_length[actuator] / self._model.actuator_gear[actuator][0])

    def _joints_of_target(self, actuator: int) -> list[int]:
        """Return the free hinges and slides that change the length of an actuator's target."""
        model, target = self._model, self._model.actuator_trnid[actuator][0]
        if model.actuator_trntype[actuator] == mujoco.mjtTrn.mjTRN_TENDON:
            start = model.ten_J_rowadr[target]
            dofs = model.ten_J_colind[start : start + model.ten_J_rownnz[target]]
            joints = {int(model.dof_jntid[dof]) for dof in dofs}
        else:
            joints = {int(target)}
        leaders = {first: second for first, second, _ in self._followers}
        address = {int(model.jnt_qposadr[j]): j for j in range(model.njnt)}
        free = set()
        for joint in joints:
            at = int(model.jnt_qposadr[joint])
            for _ in range(len(leaders) + 1):
                at = leaders.get(at, at)
            if at >= 0 and at not in leaders:
                free.add(address[at])
        return sorted(free)

    def _ends(self, joint: int, on_path: bool) -> tuple[float, float]:
        """Return the range of a joint; one revolution for an unlimited hinge on a path."""
        model = self._model
        low, high = model.jnt_range[joint] if model.jnt_limited[joint] else (-math.inf, math.inf)
        is_open, kind = math.isinf(low) and math.isinf(high), mujoco.mjtJoint(model.jnt_type[joint])
        if is_open and on_path and kind == mujoco.mjtJoint.mjJNT_HINGE:
            start = model.qpos0[model.jnt_qposadr[joint]]
            return start - math.pi, start + math.pi
        if kind in (mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_BALL):
            return -math.inf, math.inf
        return low, high

    def _is_spatial(self, actuator: int) -> bool:
        model = self._model
        if model.actuator_trntype[actuator] != mujoco.mjtTrn.mjTRN_TENDON:
            return False
        first = model.wrap_type[model.tendon_adr[model.actuator_trnid[actuator][0]]]
        return bool(first != mujoco.mjtWrap.mjWRAP_JOINT)

    def _coupled_joints(self) -> list[tuple[int, int, Any]]:
        """Return coupled joints, leaders first: address, leader address in qpos or -1, powers."""
        model, coupled = self._model, []
        for k in range(model.neq):
            if model.eq_type[k] == mujoco.mjtEq.mjEQ_JOINT and model.eq_active0[k]:
                first, second = model.eq_obj1id[k], model.eq_obj2id[k]
                leader = int(model.jnt_qposadr[second]) if second >= 0 else -1
                powers = model.eq_data[k][: 5 if second >= 0 else 1].copy()
                coupled.append((int(model.jnt_qposadr[first]), leader, powers))
        leaders = {first: leader for first, leader, _ in coupled}

        def depth(at: int) -> int:
            for count in range(len(leaders)):
                if at not in leaders:
                    return count
                at = leaders[at]
            return len(leaders)

        return sorted(coupled, key=lambda item: depth(item[0]))


def main() -> None:
    """Answer the request on stdin; output of MuJoCo is redirected to stderr."""
    stdout = os.dup(1)
    os.dup2(2, 1)
    request = json.load(sys.stdin.buffer)
    limit_resources(request["memory"], request["seconds"])
    content = json.dumps(answer(request, close_files)).encode()
    with os.fdopen(stdout, "wb") as stream:
        stream.write(content)


if __name__ == "__main__":
    main()
