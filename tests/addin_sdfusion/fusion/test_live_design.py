"""Tests with a robot and bodies read in real Fusion, drawn in the fake and exported."""

from __future__ import annotations

import random
from dataclasses import replace
from pathlib import Path
from typing import Any

import fake_fusion
import numpy as np
import pytest
from fake_fusion import Builder, designs
from support.designs.design_strategies import matrix
from support.designs.live_assembly import Drawn, live_data

from addin_sdfusion.building.build_robot import build_robot
from addin_sdfusion.exporting.export import export_robot
from addin_sdfusion.robot.formats.read import read_robot
from addin_sdfusion.settings import ExportSettings

with fake_fusion.modules():
    from addin_sdfusion.fusion.design import read_design


def truth(drawn: Drawn) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return position in the root frame, in [m], and axis of each joint, by moving occurrence."""
    return {
        joint["occurrence_one"]: (
            0.01 * np.array(joint["transform_in_root_cm"]).reshape(4, 4)[:3, 3],
            np.array(joint["rotationAxisVector_as_reported"]),
        )
        for joint in drawn.data["as_built_joints"]
    }


@pytest.mark.slow
def test_joints_of_a_real_robot_have_the_positions_of_fusion(fusion: Any, tmp_path: Path) -> None:
    """Six legs with as-built joints in the frame of the leg, and obsolete groups."""
    drawn = Drawn()
    for path in drawn.paths.values():
        if path and not path[-1].component.occurrences and not path[-1].component.bodies:
            drawn.build.box(path, (1.0, 2.0, 3.0))
    # The data do not contain the body that carries the legs.
    mounts = [drawn.paths[f"part_01:{k}+part_05:1+part_06:1"] for k in range(2, 8)]
    drawn.build.rigid_group("mount", [drawn.paths["part_00:1"], *mounts])
    design = drawn.build.done()
    snapshot = read_design(design, meshes=False)
    expected = truth(drawn)
    assert len(snapshot.occurrences) == 97
    assert len(snapshot.joints) == len(expected) == 18
    for joint in snapshot.joints:
        assert joint.one is not None
        origin, axis = expected[joint.one]
        assert joint.origin_one == pytest.approx(origin, abs=1e-9)
        assert joint.origin_two == pytest.approx(origin, abs=1e-9)
        assert joint.motions[0].axis == pytest.approx(axis, abs=1e-9)
    assert {f.code for f in snapshot.findings} == {"same-name", "stale-group"}

    leaves = [f for f, p in drawn.paths.items() if p and not p[-1].component.occurrences]
    settings = ExportSettings(components=tuple(leaves), links="components", base="part_00")
    built = build_robot(replace(snapshot, settings=settings))
    assert built.robot is not None, [f.message for f in built.findings if f.is_error]
    moving = [joint for joint in built.robot.joints if joint.motions]
    assert len(moving) == 18
    places = [origin for origin, _ in expected.values()]
    for joint in moving:
        T = matrix(built.T_world_link[joint.child]) @ matrix(joint.T_child_joint)
        assert min(np.linalg.norm(T[:3, 3] - place) for place in places) < 1e-9
    assert {f.code for f in built.findings if f.subject.kind in ("joint", "group")} <= {"same-name"}

    export_robot(replace(snapshot, settings=settings), tmp_path / "robot")
    assert len(read_robot(tmp_path / "robot").coordinates) == 18


@pytest.mark.slow
def test_inertias_of_real_bodies_are_read_correctly(fusion: Any) -> None:
    """127 bodies: getXYZMomentsOfInertia returns entries of the inertia matrix."""
    bodies = live_data("live_masses.json")["bodies"]
    build = Builder("bodies")
    order = random.Random(5)
    base = build.place("base", grounded=True)
    build.box(base, (1.0, 1.0, 1.0))
    expected: dict[str, tuple[float, np.ndarray, float]] = {}
    for k, body in enumerate(bodies):
        com, moments = np.array(body["com_component_local"]), body["inertia_at_origin"]
        m = body["mass_kg"]
        about_origin = np.array(
            [
                [moments["ixx"], moments["ixy"], moments["ixz"]],
                [moments["ixy"], moments["iyy"], moments["iyz"]],
                [moments["ixz"], moments["iyz"], moments["izz"]],
            ]
        )
        inertia = about_origin - m * (com @ com * np.eye(3) - np.outer(com, com))
        T = designs.random_motion(order)
        path = build.place(f"body {k}", T)
        build.explicit(path, m, 100.0 * com, 1e4 * inertia, size=(100.0, 100.0, 100.0))
        build.joint(f"joint {k}", "revolute", path, base)
        far = m * np.linalg.norm(0.01 * T[:3, 3]) ** 2  # scale of Fusion's values
        expected[f"body {k}"] = (m, T[:3, :3] @ inertia @ T[:3, :3].T, far)
    built = build_robot(read_design(build.done(), meshes=False))
    assert built.robot is not None, [f.message for f in built.findings if f.is_error]
    assert len(expected) == 127
    for name, (m, inertia, far) in expected.items():
        link = built.robot.link(name)
        R = matrix(built.T_world_link[name])[:3, :3]
        assert link.inertia.mass == pytest.approx(m, rel=1e-12)
        found = R @ np.array(link.inertia.matrix) @ R.T
        assert found == pytest.approx(inertia, abs=1e-9 * np.trace(inertia) + 1e-15 * far)
