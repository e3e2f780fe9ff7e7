"""Converted robots in other programs: M, bias, l and L agree to 1e-9, or a finding explains why."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import mujoco
import numpy as np
import pytest
from support.cases import sample_cases
from support.oracles.mujoco_model import dense_tendon_jacobian
from support.robots.every_field import robot_of_every_field
from support.robots.one_link import one_link
from support.robots.random_robots import random_robot
from support.robots.wrapped import sequences, single_wraps, wrapped_tree

from addin_sdfusion.robot import (
    WORLD,
    Finding,
    Muscle,
    PointMotion,
    Polynomial,
    Robot,
    RobotError,
    ViaPoint,
    read_robot,
)
from addin_sdfusion.robot.formats.convert import FORMATS, convert
from addin_sdfusion.robot.formats.mjcf.capabilities import mjcf_losses
from addin_sdfusion.robot.formats.read import read
from addin_sdfusion.robot.formats.sdf.write_joints import sdf_joints
from sim_dart import DartDynamics
from sim_dart.core.arrays import FloatArray

EXAMPLES = Path(__file__).parents[4] / "examples"
OURS = ("hill_arm", "planar_2r", "pick_up", "pneumatic_elbow", "roboy_left_arm")
PUBLISHED = tuple(
    f"caspr/{name}"
    for name in ("BMArm", "Example_2R_planar_XZ", "Example_planar_XY", "Example_spatial",
                 "Example_spherical", "FASTKIT_Planar", "MACARM", "RoboyLeftArm", "RoboyUpperBody")
) + tuple(
    f"cardsflow/{name}"
    for name in ("VRpuppet", "exosuit", "msj_platform", "musc-le", "roboy_icecream",
                 "roboy_upper_body", "shoulder_testbed", "test_robot", "theClaw")
)  # fmt: skip
"""Robots that have no errors after the repair."""
PATHS = {"via-point-inside-wrap", "wrap-left-out", "turns-left-out", "side-by-place",
         "wrap-approximated", "pulley-left-out", "caspr-wrap",
         "points-beyond-their-range"}  # fmt: skip
"""Findings on muscles whose path differs."""
CLOSE = 1e-9


def _states(robot: Robot) -> Iterator[tuple[FloatArray, FloatArray]]:
    rng = np.random.default_rng(1)
    lower = [max(c.lower, -1.5) for c in robot.coordinates]
    upper = [max(low, min(c.upper, 1.5)) for low, c in zip(lower, robot.coordinates, strict=True)]
    for _ in range(4):
        yield rng.uniform(lower, upper), rng.uniform(-1.0, 1.0, len(lower))


def _bare(robot: Robot) -> Robot:
    """Return the robot without springs and friction in its joints, which have separate findings."""
    joints = []
    for joint in robot.joints:
        bare = [replace(c, stiffness=0.0, friction=0.0) for c in joint.coordinates]
        joints.append(replace(joint, coordinates=tuple(bare)))
    return replace(robot, joints=tuple(joints))


def _near(found: FloatArray, expected: FloatArray) -> None:
    size = max(1.0, np.abs(expected).max(initial=0.0))
    np.testing.assert_allclose(found / size, expected / size, rtol=0.0, atol=CLOSE)


class Lines(NamedTuple):
    """Muscle lengths, shape (m,), and their gradients, shape (m, n)."""

    lengths: FloatArray
    L: FloatArray


def _paths_near(robot: Robot, findings: list[Finding], found: Lines, expected: Lines) -> None:
    """Compare the paths, except of muscles that a finding names."""
    reported = {finding.subject.name for finding in findings if finding.code in PATHS}
    listing = "".join(f.message for f in findings if f.code == "ends-move-near-wraps")
    apart = np.abs(found.lengths - expected.lengths)
    tilted = np.abs(found.L - expected.L).max(axis=1, initial=0.0)
    other = {m.name for m, a, b in zip(robot.muscles, apart, tilted, strict=True)
             if max(a, b) > CLOSE}  # fmt: skip
    assert {name for name in other if repr(name) not in listing} <= reported


def _lines(dynamics: DartDynamics, q: FloatArray) -> Lines:
    return Lines(dynamics.muscle_lengths(q), dynamics.muscle_jacobian(q))


def _in_opensim(robot: Robot, folder: Path) -> None:
    from support.oracles.opensim_model import OpenSimRobot

    theirs, ours = OpenSimRobot(robot, folder), DartDynamics(_bare(robot))
    theirs.without_forces()
    findings = convert(robot, "osim", folder, overwrite=True).findings
    for q, qd in _states(robot):
        theirs.move(q, qd)
        _near(theirs.mass_matrix, ours.mass_matrix(q))
        _near(theirs.bias, ours.coriolis(q, qd) + ours.gravity(q))
        _paths_near(robot, findings, Lines(theirs.lengths, -theirs.moment_arms), _lines(ours, q))


def _in_caspr(robot: Robot, folder: Path) -> None:
    """Return the result of reading the CASPR files again."""
    findings = convert(robot, "caspr", folder, overwrite=True).findings
    again = read_robot(folder, robot.cable_set or None)
    theirs, ours = DartDynamics(again), DartDynamics(_bare(robot))
    for q, qd in _states(robot):
        _near(theirs.mass_matrix(q), ours.mass_matrix(q))
        _near(theirs.coriolis(q, qd) + theirs.gravity(q), ours.coriolis(q, qd) + ours.gravity(q))
        _paths_near(robot, findings, _lines(theirs, q), _lines(ours, q))


def _in_pinocchio(robot: Robot, folder: Path) -> None:
    pinocchio = pytest.importorskip("pinocchio", reason="needs the extra pinocchio, for tests")
    (file,) = (
        f for f in convert(robot, "urdf", folder, overwrite=True).files if f.suffix == ".urdf"
    )
    model = pinocchio.buildModelFromXML(file.read_text(encoding="utf-8"))
    model.gravity.linear = np.array(robot.gravity)
    data, ours = model.createData(), DartDynamics(_bare(robot))
    joints = [model.joints[model.getJointId(c.name)] for c in robot.coordinates]
    order = [joint.idx_v for joint in joints]
    assert sorted(order) == list(range(model.nv))
    for q, qd in _states(robot):
        theirs, speeds = np.zeros(model.nq), np.zeros(model.nv)
        for joint, angle, speed in zip(joints, q, qd, strict=True):
            on_circle = (np.cos(angle), np.sin(angle)) if joint.nq == 2 else (angle,)
            theirs[joint.idx_q : joint.idx_q + joint.nq] = on_circle
            speeds[joint.idx_v] = speed
        M = np.triu(pinocchio.crba(model, data, theirs))
        M += np.triu(M, 1).T
        _near(M[np.ix_(order, order)], ours.mass_matrix(q))
        bias = pinocchio.nle(model, data, theirs, speeds)[order]
        _near(bias, ours.coriolis(q, qd) + ours.gravity(q))


def _in_mujoco(robot: Robot, folder: Path) -> None:
    rejected = {finding.code for finding in mjcf_losses(robot) if finding.is_error}
    if rejected:
        assert rejected == {"inertia-triangle"}  # physically impossible inertias
        with pytest.raises(RobotError) as refusal:
            convert(robot, "mjcf", folder, overwrite=True)
        assert "--repair" not in str(refusal.value)  # these robots are repaired
        return
    done = convert(robot, "mjcf", folder, overwrite=True)
    model = mujoco.MjModel.from_xml_path(str(done.files[0]))
    data, ours = mujoco.MjData(model), DartDynamics(_bare(robot))
    order = [model.joint(name).dofadr[0] for name in ours.coordinate_names]
    for q, qd in _states(robot):
        data.qpos[order], data.qvel[order] = q, qd
        mujoco.mj_forward(model, data)
        M = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, M)
        _near(M[np.ix_(order, order)], ours.mass_matrix(q))
        _near(data.qfrc_bias[order], ours.coriolis(q, qd) + ours.gravity(q))
        found = Lines(data.ten_length.copy(), dense_tendon_jacobian(model, data)[:, order])
        _paths_near(robot, done.findings, found, _lines(ours, q))


def _in_drake(robot: Robot, folder: Path) -> None:
    """Return the result in Drake without muscles, which only our plug-in supports in SDF."""
    from support.oracles.drake_model import DrakeRobot

    robot = _as_drake_has_it(robot)
    done = convert(robot, "sdf", folder, overwrite=True)
    (file,) = (f for f in done.files if f.name == "model.sdf")
    theirs, ours = DrakeRobot(read_robot(file), file), DartDynamics(robot)
    damping = np.array([c.damping for c in robot.coordinates])
    if any(finding.code == "sdf-inertia-refused" for finding in done.findings):
        return  # Drake reads it with different inertias
    for q, qd in _states(robot):
        theirs.move(q, qd)
        _near(theirs.mass_matrix, ours.mass_matrix(q))
        _near(theirs.resistance, ours.coriolis(q, qd) + ours.gravity(q) + damping * qd)


def _as_drake_has_it(robot: Robot) -> Robot:
    """Return the robot without features of universal joints that Drake does not support."""
    universal = {
        name
        for name, parts in sdf_joints(robot).items()
        if any(part.type == "universal" for part in parts)
    }
    free = {"stiffness": 0.0, "damping": 0.0}
    joints = (
        replace(joint, coordinates=tuple(replace(c, **free) for c in joint.coordinates))
        if joint.name in universal
        else joint
        for joint in robot.joints
    )
    return replace(robot, joints=tuple(joints))


PROGRAMS = {
    "osim": _in_opensim,
    "caspr": _in_caspr,
    "urdf": _in_pinocchio,
    "mjcf": _in_mujoco,
    "sdf": _in_drake,
}
MUJOCO_MISSING = {"osim": "opensim", "urdf": "pinocchio", "sdf": "pydrake"}


def _held(robot: Robot, format_: str, folder: Path) -> None:
    pytest.importorskip(MUJOCO_MISSING.get(format_, "numpy"))
    for group in robot.cable_sets or (None,):
        active = robot if group is None else robot.with_cable_set(group.name)
        PROGRAMS[format_](active, folder)


@pytest.mark.parametrize("format_", PROGRAMS)
@pytest.mark.parametrize("name", OURS)
def test_examples_agree(name: str, format_: str, tmp_path: Path) -> None:
    _held(read_robot(EXAMPLES / name / "robot"), format_, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("format_", PROGRAMS)
@pytest.mark.parametrize("name", PUBLISHED)
def test_published_robots_agree(name: str, format_: str, shared: Path, tmp_path: Path) -> None:
    robot = read(shared / "robots" / name, repair=True).require()
    _held(robot, format_, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("format_", ["osim", "sdf"])
def test_arm26_agrees(format_: str, shared: Path, tmp_path: Path) -> None:
    """OpenSim's paths over cylinders are not the shortest paths."""
    _held(read(shared / "models/opensim/arm26.osim").require(), format_, tmp_path)


@pytest.mark.parametrize(("limit", "is_said"), [(0.5, False), (math.inf, True)])
def test_points_that_move_within_a_range_agree(limit: float, is_said: bool, tmp_path: Path) -> None:
    """Beyond the range OpenSim's moment arms are not the derivatives of its lengths."""
    motion = PointMotion((1.0, 0.0, 0.0), "q", Polynomial((0.05, 0.1)), -0.5, 0.5)
    points = (ViaPoint(WORLD, (0.0, 0.3, 0.0)), ViaPoint("a", (0.2, 0.1, 0.0), moves=(motion,)))
    robot = one_link(muscles=[Muscle("m", points)], lower=-limit, upper=limit)
    codes = {finding.code for finding in convert(robot, "osim", tmp_path).findings}
    assert ("points-beyond-their-range" in codes) == is_said
    _held(robot, "osim", tmp_path)


@pytest.mark.cases(28)
@pytest.mark.parametrize("format_", PROGRAMS)
@pytest.mark.parametrize("seed", sample_cases(range(12)))
def test_random_robots_agree(seed: int, format_: str, tmp_path: Path) -> None:
    _held(random_robot(seed), format_, tmp_path)


@pytest.mark.cases(40)
@pytest.mark.parametrize(
    ("format_", "seed"),
    sample_cases(
        [(f, seed) for seed in range(1, 25) for f in PROGRAMS if seed % 2 or f != "caspr"], 5
    ),
)
def test_random_robots_of_every_field_agree(seed: int, format_: str, tmp_path: Path) -> None:
    """CASPR supports few joints in rotated frames, which even seeds have."""
    robot = robot_of_every_field(seed)
    simulated = [m for m in robot.muscles if not m.name.startswith(("at ", "by "))]
    surfaces = tuple(s for s in robot.wrap_surfaces if s.shape != "ellipsoid")
    robot = replace(robot.with_muscles(simulated), wrap_surfaces=surfaces)
    _held(robot, format_, tmp_path)


@pytest.mark.parametrize("format_", ["osim", "caspr"])
@pytest.mark.parametrize("seed", sample_cases(range(8)))
def test_random_robots_with_wraps_agree(seed: int, format_: str, tmp_path: Path) -> None:
    rng = np.random.default_rng(seed)
    for k, robot in enumerate(
        [
            single_wraps(rng, 12, sides=(-1, 0, 0, 1), lengths=(0.5, np.inf)),
            sequences(rng, 4, 3, sides=(0, 1)),
            wrapped_tree(random_robot(seed, 3, 4), seed),
        ]
    ):
        _held(robot, format_, tmp_path / str(k))


def test_all_formats_are_tested() -> None:
    """Gazebo files, cardsflow.xml and muscles.csv are read again in separate tests."""
    assert set(FORMATS) == {*PROGRAMS, "gazebo", "cardsflow", "muscles.csv"}
