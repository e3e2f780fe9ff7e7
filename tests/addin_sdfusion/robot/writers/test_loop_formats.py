"""Loop joints in MJCF and OpenSim constrain the same motions as the original ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import null_space
from support.oracles.loop_model import loop_jacobian, pose_matrix, residuals
from support.robots.loops import closed_chain, four_bar, random_loops, with_loop

from addin_sdfusion.robot import WORLD, LoopJoint, Pose, Robot, read_robot
from addin_sdfusion.robot.formats.mjcf.capabilities import mjcf_losses
from addin_sdfusion.robot.formats.mjcf.write import write_mjcf
from addin_sdfusion.robot.formats.mjcf.write_constraints import LOOPS
from addin_sdfusion.robot.formats.opensim.capabilities import osim_losses
from addin_sdfusion.robot.formats.opensim.write import write_osim
from addin_sdfusion.robot.formats.opensim.writing.loops import SUPPORTED
from addin_sdfusion.robot.formats.reading.loops import closing_joints
from addin_sdfusion.robot.model.loop import AXES, LOOP_TYPES, LoopType
from addin_sdfusion.robot.transforms.joint_chains import Names
from addin_sdfusion.robot.transforms.loop_points import LoopPoint, join_points, loop_points
from sim_dart import CoreDynamics

AXIS, OTHER = (0.0, 0.6, 0.8), (1.0, 0.0, 0.0)
PARENT, CHILD = Pose((0.5, 0.1, -0.2), (0.3, 0.2, -0.4)), Pose((0.1, 0.2, 0.3), (0.4, -0.5, 0.6))


def of_type(kind: LoopType) -> Robot:
    axes, robot = (AXIS, OTHER)[: AXES[kind]], four_bar()
    first, *others = robot.muscles
    robot = robot.with_muscles([replace(first, name="closing_axes"), *others])
    return with_loop(robot, type=kind, axes=axes, T_parent_joint=PARENT, T_child_joint=CHILD)


def gaps(robot: Robot, q: Any) -> Any:
    """Return the distance of the points and the remaining residuals' norm."""
    found = residuals(robot, q.astype(complex)).real
    return np.linalg.norm(found[:3]), np.linalg.norm(found[3:])


@pytest.mark.parametrize(
    ("write", "kind"),
    [(write_mjcf, kind) for kind in LOOPS] + [(write_osim, kind) for kind in SUPPORTED],
)
def test_loop_joint_is_restored(
    kind: LoopType, write: Callable[..., list[Path]], tmp_path: Path
) -> None:
    robot = of_type(kind)
    (file,) = write(robot, tmp_path)
    other = read_robot(file)
    (loop,) = other.loops
    assert (loop.name, loop.type) == ("closing", kind)
    names = [c.name for c in other.coordinates]
    order = [names.index(c.name) for c in robot.coordinates]
    for q in np.random.default_rng(3).uniform(-1.0, 1.0, (5, 3)):
        theirs = np.empty(3)
        theirs[order] = q
        assert gaps(other, theirs) == pytest.approx(gaps(robot, q), abs=1e-12)


def conditions(loop: LoopJoint) -> tuple[LoopPoint, ...]:
    return loop_points(loop, Names())


@pytest.mark.parametrize("kind", ["revolute", "universal", "cylindrical", "prismatic"])
def test_other_points_do_not_form_a_joint(kind: LoopType) -> None:
    """The last condition is moved, or belongs to other links."""
    (loop,) = of_type(kind).loops
    *first, last = conditions(loop)
    assert [joint.type for joint in join_points((*first, last))[0]] == [kind]
    x, y, z = last.in_child
    moved = replace(last, in_child=(x + 1e-6, y + 2e-6, z - 1e-6))
    for changed in (replace(last, child="crank_bar"), moved):
        joints, others = join_points((*first, changed))
        if kind == "cylindrical" and changed is moved:  # any two points define its axis
            assert joints[0].type == kind
            continue
        assert kind not in [joint.type for joint in joints]
        assert len(joints) + len(others) >= 2


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, -1.0, 0.0)])
def test_hinges_with_opposite_axes_in_their_links_are_joined(axis: Any) -> None:
    """The frame on the child is rotated by up to half a turn."""
    a, b, c = axis
    points = (
        LoopPoint("a", "p", "c", "point", (0.0, 0.0, 0.0), (0.1, 0.0, 0.0)),
        LoopPoint("b", "p", "c", "point", (0.2, 0.0, 0.0), (0.1 + 0.2 * a, 0.2 * b, 0.2 * c)),
    )
    ((hinge,), _) = join_points(points)
    R = pose_matrix(hinge.T_child_joint)[:3, :3]
    assert R @ hinge.axes[0] == pytest.approx(axis, abs=1e-15)


@pytest.mark.parametrize("kind", ["universal", "cylindrical", "prismatic"])
def test_a_loop_whose_child_is_the_world_has_its_links_exchanged(kind: LoopType) -> None:
    """The exchanged loop joints are closed at the same pose and allow the same motions."""
    robot, q = random_loops(1, [kind])
    turned = []
    for loop in robot.loops:
        names = {loop.parent: "a", loop.child: WORLD}
        given = replace(loop, parent="a", child=WORLD)
        ((made,), _) = closing_joints(conditions(given), {}, {"a": "0", WORLD: "1"})
        assert (made.parent, made.child) == (WORLD, "a")
        back = {new: old for old, new in names.items()}
        turned.append(replace(made, parent=back[WORLD], child=back["a"]))
    other = replace(robot, loops=tuple(turned))
    assert np.abs(residuals(other, q)).max() < 1e-12
    free = null_space(loop_jacobian(robot, q), rcond=1e-9)
    assert np.abs(loop_jacobian(other, q) @ free).max() < 1e-9
    assert null_space(loop_jacobian(other, q), rcond=1e-9).shape == free.shape


@pytest.mark.parametrize(("losses", "held"), [(mjcf_losses, LOOPS), (osim_losses, SUPPORTED)])
def test_other_types_are_reported(losses: Any, held: Any) -> None:
    for kind in LOOP_TYPES:
        said = [f.message for f in losses(of_type(kind)) if f.code == "loop-left-out"]
        assert [f"closing ({kind})" in text for text in said] == [True] * (kind not in held)


@pytest.mark.interop
@pytest.mark.parametrize("kind", SUPPORTED)
def test_loops_close_in_opensim(kind: LoopType, tmp_path: Path) -> None:
    """At a closed pose, constraint errors are zero, and accelerations are those of the core."""
    opensim_model = pytest.importorskip("support.oracles.opensim_model")
    robot, q = closed_chain(kind)
    model = opensim_model.OpenSimRobot(robot, tmp_path)
    for c, value in zip(model.coordinates, q, strict=True):
        c.setValue(model.state, value, False)
        c.setSpeedValue(model.state, 0.0)
    model.model.realizeAcceleration(model.state)
    errors = model.state.getQErr()
    assert max(abs(errors.get(k)) for k in range(model.state.getNQErr())) < 1e-14
    found = [c.getAccelerationValue(model.state) for c in model.coordinates]
    expected = CoreDynamics(robot).acceleration(q, 0 * q, 0 * q)
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-10)


@pytest.mark.interop
@pytest.mark.parametrize("kind", LOOPS)
def test_loops_close_in_mujoco(kind: LoopType, tmp_path: Path) -> None:
    """At a closed pose, constraint errors are zero, and the free motions are those of the core."""
    mujoco = pytest.importorskip("mujoco")
    robot, q = closed_chain(kind)
    (file,) = write_mjcf(robot, tmp_path)
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    data.qpos = q
    mujoco.mj_forward(model, data)
    assert np.abs(data.efc_pos).max() < 1e-14
    assert len(data.efc_pos) == {"fixed": 6, "ball": 3, "revolute": 6, "universal": 4}[kind]
    J, expected = data.efc_J.reshape(-1, model.nv), loop_jacobian(robot, q)
    assert np.linalg.matrix_rank(J, 1e-9) == np.linalg.matrix_rank(expected, 1e-9)
    assert np.abs(J @ null_space(expected, rcond=1e-9)).max() < 1e-12
