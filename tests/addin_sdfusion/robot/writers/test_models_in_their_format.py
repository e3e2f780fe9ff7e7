"""Models of OpenSim, MuJoCo and URDF are restored after writing them in their format."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.robots.driven import leg
from support.robots.robot_differences import differences
from support.third_party_models import OSIM, WHOLE_MJCF

from addin_sdfusion.robot import (
    Coordinate,
    Joint,
    Motion,
    Polynomial,
    Robot,
    RobotError,
    SimmSpline,
    Term,
    read_robot,
    write_sdf,
)
from addin_sdfusion.robot.formats.convert import convert
from addin_sdfusion.robot.formats.read import read
from sim_dart import CoreDynamics

FOLDERS = {"osim": "opensim/*.osim", "mjcf": "mjcf/*.xml"}


def again(robot: Robot, format_: str, folder: Path) -> Robot:
    return read_robot(convert(robot, format_, folder).files[0])


def models(shared: Path, format_: str) -> Iterator[Robot]:
    for file in sorted((shared / "models").glob(FOLDERS[format_])):
        yield read_robot(file)


@pytest.mark.slow
@pytest.mark.parametrize("format_", FOLDERS)
def test_published_models_are_restored(shared: Path, format_: str, tmp_path: Path) -> None:
    for k, robot in enumerate(models(shared, format_)):
        written = again(robot, format_, tmp_path / str(k))
        assert list(differences(robot, written)) == [], robot.name


@pytest.mark.slow
def test_published_models_open_in_opensim_with_equal_lengths(shared: Path, tmp_path: Path) -> None:
    """With conditional and moving points, couplers and wraps."""
    opensim = pytest.importorskip("opensim")
    opensim.Logger.setLevelString("off")

    def lengths(file: Path) -> dict[str, float]:
        model = opensim.Model(str(file))
        state = model.initSystem()
        return {m.getName(): m.getLength(state) for m in model.getMuscles()}

    for file in sorted((shared / "models").glob(FOLDERS["osim"])):
        written = convert(read_robot(file), "osim", tmp_path / file.stem).files[0]
        assert lengths(written) == pytest.approx(lengths(file), abs=1e-6), file.stem


@pytest.mark.slow
@pytest.mark.parametrize("format_", FOLDERS)
def test_published_models_are_restored_from_urdf(
    shared: Path, format_: str, tmp_path: Path
) -> None:
    """Except link frames, which URDF moves to the joints: restored after a second conversion."""
    for k, robot in enumerate(models(shared, format_)):
        first = again(robot, "urdf", tmp_path / f"{k}")
        second = again(first, "urdf", tmp_path / f"{k} again")
        assert list(differences(first, second)) == [], robot.name
        assert first.joints[-1].coordinates == robot.joints[-1].coordinates


def test_small_models_with_all_features_are_restored(tmp_path: Path) -> None:
    (tmp_path / "leg.osim").write_text(OSIM.replace("<default_value>0.3", "<default_value>0.1"))
    (tmp_path / "arm.xml").write_text(WHOLE_MJCF)
    for name, format_ in (("leg.osim", "osim"), ("arm.xml", "mjcf")):
        robot = read(tmp_path / name).require()
        assert list(differences(robot, again(robot, format_, tmp_path / format_))) == []


def _changed(robot: Robot, coordinate: str, **words: object) -> Robot:
    joints = (
        replace(j, coordinates=tuple(replace(c, **words) if c.name == coordinate else c  # type: ignore[arg-type]
                                     for c in j.coordinates))
        for j in robot.joints
    )  # fmt: skip
    return replace(robot, joints=tuple(joints))


def test_splines_of_joints_and_couplings_are_restored_from_opensim(tmp_path: Path) -> None:
    """OpenSim supports a function of one coordinate, or a linear function of several."""
    with pytest.raises(RobotError, match="'glide': OpenSim couples"):
        convert(leg(), "osim", tmp_path)
    spline = SimmSpline((-1.0, 0.0, 1.0, 2.0), (0.1, 0.0, 0.05, 0.3))
    lines = (Term("flexion", Polynomial((0.02, 0.7))), Term("hip", Polynomial((0.0, -0.2))))
    for k, coupling in enumerate(((Term("hip", spline),), lines)):
        robot = _changed(leg(), "glide", coupling=coupling)
        found = again(robot, "osim", tmp_path / str(k))
        expected = [replace(j, coordinates=tuple(_as_in_opensim(c) for c in j.coordinates))
                    for j in robot.joints]  # fmt: skip
        assert list(differences(tuple(expected), found.joints)) == []


def _as_in_opensim(c: Coordinate) -> Coordinate:
    """Return the coordinate without armature and motor limits, which OpenSim does not support."""
    return replace(c, armature=0.0)


def test_polynomial_motions_have_equal_dynamics_in_mujoco(tmp_path: Path) -> None:
    """Each motion is a separate joint, coupled by an equality."""
    with pytest.raises(RobotError, match="polynomials of degree 4"):
        convert(leg(), "mjcf", tmp_path)
    robot = _changed(leg(), "glide", coupling=(Term("hip", Polynomial((0.1, -0.4, 0.2))),))
    robot = _changed(robot, "sway", limit_force=None)

    def powers(motion: Motion) -> Motion:
        is_held = isinstance(motion.function, Polynomial)
        return motion if is_held else replace(motion, function=Polynomial((0.1, 0.2, -0.3, 0.1)))

    def with_sway(joint: Joint) -> Joint:
        if joint.name != "knee":
            return joint
        plain = replace(joint.motions[-1], function=Polynomial((0.05, 1.0)))
        return replace(joint, motions=(*joint.motions[:-1], plain))

    joints = (replace(j, motions=tuple(map(powers, j.motions))) for j in robot.joints)
    robot = replace(robot, joints=tuple(map(with_sway, joints)))
    written = again(robot, "mjcf", tmp_path)
    ours, theirs = CoreDynamics(robot), CoreDynamics(written)
    order = [theirs.coordinate_names.index(name) for name in ours.coordinate_names]
    rng = np.random.default_rng(0)
    for _ in range(3):
        q, u = rng.uniform(-1.0, 1.0, (2, ours.n))
        q2, u2 = np.empty(theirs.n), np.empty(theirs.n)
        q2[order], u2[order] = q, u
        M = theirs.mass_matrix(q2)[np.ix_(order, order)]
        np.testing.assert_allclose(M, ours.mass_matrix(q), atol=1e-13)
        bias = (theirs.coriolis(q2, u2) + theirs.gravity(q2))[order]
        np.testing.assert_allclose(bias, ours.coriolis(q, u) + ours.gravity(q), atol=1e-12)
        lengths = theirs.muscle_lengths(q2)
        np.testing.assert_allclose(lengths, ours.muscle_lengths(q), atol=1e-13)


def test_driven_joints_are_restored_from_urdf(tmp_path: Path) -> None:
    """The cardsflow.xml holds what `mimic` cannot; other programs get linear functions."""
    first = again(leg(), "urdf", tmp_path / "first")
    assert list(differences(first, again(first, "urdf", tmp_path / "again"))) == []
    write_sdf(first, tmp_path / "sdf")
    assert list(differences(read_robot(tmp_path / "sdf"), first)) == []
    text = (tmp_path / "first/leg.urdf").read_text()
    assert '<mimic joint="flexion" ' in text
    assert text.count("<mimic") == 4
