"""Terms of imported MJCF files equal MuJoCo, or unsupported elements are reported."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.mjcf_files import BESIDE, FILES
from support.oracles.mujoco_file import MujocoFile

from addin_sdfusion.robot import Muscle, Robot, WrapSurface
from addin_sdfusion.robot.formats.read import read
from addin_sdfusion.robot.model.muscle_laws import law_parameters
from addin_sdfusion.robot.model.rotations import apply, inverse
from sim_dart import CoreDynamics

NEAR = 1e-10
"""Tolerance relative to the largest entry."""
TOUCHED = 1e-6
"""Tolerance for inside wraps, for which MuJoCo limits its Newton steps."""
SHARED = ("myoarm", "myoelbow_2dof6muscles", "myofinger_v0", "myohand")


def write_robot(folder: Path, name: str) -> Path:
    for place, text in (BESIDE | {"model.xml": FILES[name]}).items():
        (folder / place).parent.mkdir(exist_ok=True)
        (folder / place).write_text(text)
    return folder / "model.xml"


def assert_equal_terms(file: Path, states: int) -> Robot:
    """Compare all terms at random states within the ranges of the coordinates."""
    robot = read(file).require()
    theirs, ours = MujocoFile(file, robot), CoreDynamics(replace(robot, loops=()))
    rng = np.random.default_rng(0)
    lower = np.maximum([c.lower for c in robot.coordinates], -1.0)
    upper = np.minimum([c.upper for c in robot.coordinates], 1.0)
    for _ in range(states):
        q, u = rng.uniform(lower, upper), rng.uniform(-1.0, 1.0, ours.n)
        terms = theirs.terms(q, u)
        assert_near("M", ours.mass_matrix(q), terms.M)
        assert_near("bias", ours.coriolis(q, u) + ours.gravity(q), terms.bias)
        lengths, L = ours.muscle_lengths(q), ours.muscle_jacobian(q)
        for k, muscle in enumerate(robot.muscles):
            row = theirs.tendon_of(muscle.name)
            if row is not None:
                by = TOUCHED if touches_inside(robot, muscle) else NEAR
                assert_near(muscle.name, lengths[k], terms.lengths[row], by)
                assert_near(muscle.name, L[k], terms.L[row], by)
    return robot


def assert_near(what: str, ours: np.ndarray, theirs: np.ndarray, by: float = NEAR) -> None:
    most = np.abs(theirs).max(initial=1e-3)
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=by * most, err_msg=what)


def touches_inside(robot: Robot, muscle: Muscle) -> bool:
    for wrap in muscle.wraps:
        surface, side = robot.wrap_surface(wrap.surface), wrap.side_point
        if side is not None and _distance(side.position, surface) < surface.radius:
            return True
    return False


def _distance(point: tuple[float, float, float], surface: WrapSurface) -> float:
    return float(np.linalg.norm(apply(inverse(surface.pose), point)))


@pytest.mark.parametrize("name", FILES)
def test_imported_file_equals_mujoco(name: str, tmp_path: Path) -> None:
    file = write_robot(tmp_path, name)
    robot = assert_equal_terms(file, 3)
    model = MujocoFile(file, robot).model
    for muscle in robot.muscles:
        values, k = law_parameters(muscle.model), 0
        if muscle.model.kind == "tendon_spring":
            assert [values["rest_low"]] == pytest.approx(model.tendon_lengthspring[0, :1])
        elif muscle.name == "m":
            gear, scale = model.actuator_gear[k, 0], model.actuator_gainprm[k, 3]
            assert values["force"] == pytest.approx(gear * scale / model.actuator_acc0[k])
            lengths = [values["length_low"], values["length_high"]]
            assert lengths == pytest.approx(model.actuator_lengthrange[k] / gear)


@pytest.mark.parametrize("name", SHARED)
def test_published_model_equals_mujoco(shared: Path, name: str) -> None:
    robot = assert_equal_terms(shared / f"models/mjcf/{name}.xml", 2)
    assert len(robot.muscles) > 4
