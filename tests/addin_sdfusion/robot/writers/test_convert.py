"""Conversions change files but not robots: the dynamics are restored."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.robots.one_link import cable, one_link
from support.robots.random_robots import random_robot
from support.robots.robots import planar_2r

from addin_sdfusion.robot import InputError, Motion, RobotError, UnknownNameError, read_robot
from addin_sdfusion.robot.formats.convert import FORMATS, convert, losses_in
from addin_sdfusion.robot.formats.opensim.capabilities import osim_losses
from addin_sdfusion.robot.formats.read import read
from sim_dart import DartDynamics


@pytest.mark.parametrize("format_", ["sdf", "caspr"])
@pytest.mark.parametrize("seed", [None, 0, 1, 2])
def test_converted_robot_has_the_same_dynamics(
    format_: str, seed: int | None, tmp_path: Path
) -> None:
    """CASPR gets merged links and aligned frames, SDF the unchanged robot."""
    robot = planar_2r() if seed is None else random_robot(seed)
    conversion = convert(robot, format_, tmp_path)
    codes = {finding.code for finding in conversion.findings}
    changed = format_ == "caspr" and seed is not None
    assert ("orientation-from-zero-pose" in codes) == changed
    assert ("links-merged" in codes) == changed
    before, after = DartDynamics(robot), DartDynamics(read_robot(tmp_path))
    for q, qd in np.random.default_rng(0).uniform(-1, 1, (3, 2, before.n)):
        near = {"rtol": 0, "atol": 1e-10}
        np.testing.assert_allclose(after.mass_matrix(q), before.mass_matrix(q), **near)
        np.testing.assert_allclose(after.coriolis(q, qd), before.coriolis(q, qd), **near)
        np.testing.assert_allclose(after.gravity(q), before.gravity(q), **near)
        np.testing.assert_allclose(after.muscle_lengths(q), before.muscle_lengths(q), **near)
        np.testing.assert_allclose(after.muscle_jacobian(q), before.muscle_jacobian(q), **near)


@pytest.mark.parametrize("format_", FORMATS)
def test_all_formats_write_the_planar_arm_and_report_omissions(
    format_: str, tmp_path: Path
) -> None:
    conversion = convert(planar_2r(), format_, tmp_path)
    assert conversion.files
    assert all(file.stat().st_size > 100 for file in conversion.files)
    codes = {finding.code for finding in conversion.findings}
    assert ("cable-sets-left-out" in codes) == (format_ not in ("sdf", "gazebo", "caspr", "urdf"))


def test_unknown_format_lists_known_ones(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match="no format 'urfd'; did you mean 'urdf'"):
        convert(planar_2r(), "urfd", tmp_path)


def test_rejected_robot_writes_no_files(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        convert(planar_2r(), "sdf", tmp_path / "file")
    robot = random_robot(0)
    clash = replace(robot.joints[0], name="__a__")
    named = replace(robot, joints=(clash, *robot.joints[1:]))
    with pytest.raises(RobotError, match="SDF reserves the name"):
        convert(named, "sdf", tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_folder_with_another_robot_is_reported(tmp_path: Path) -> None:
    robot = planar_2r()
    for again in range(2):
        codes = {finding.code for finding in convert(robot, "caspr", tmp_path).findings}
        assert "beside-other-robots" not in codes, again
    other = convert(replace(robot, name="other"), "caspr", tmp_path)
    assert "planar_2r_bodies.xml" in other.findings[-1].message
    assert read_robot(other.files[0]).name == "other"


def test_missing_coriolis_term_in_opensim_is_reported() -> None:
    """It affects three rotations by one coordinate; see test_reference_numbers for its size."""
    robot = one_link()
    axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    for count, expected in ((2, set()), (3, {"coriolis-in-opensim"})):
        motions = tuple(Motion("rotation", axis) for axis in axes[:count])
        turning = replace(robot, joints=(replace(robot.joints[0], motions=motions),))
        codes = {f.code for f in osim_losses(turning) if f.subject.kind == "joint"}
        assert codes == expected


@pytest.mark.parametrize("format_", ["sdf", "urdf", "cardsflow"])
def test_source_files_are_not_overwritten(format_: str, tmp_path: Path) -> None:
    """Here a cardsflow.xml, which three of the formats write; the others use another file."""
    convert(one_link(muscles=[cable((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))]), "gazebo", tmp_path)
    reading = read(tmp_path)
    before = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    assert {"model.sdf", "cardsflow.xml"} <= {file.name for file in reading.files}
    with pytest.raises(InputError, match="is an input of the conversion and is not overwritten"):
        convert(reading.require(), format_, tmp_path, sources=reading.files)
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == before
    convert(reading.require(), "mjcf", tmp_path, sources=reading.files)
    convert(reading.require(), format_, tmp_path / "new", sources=reading.files)


@pytest.mark.parametrize("format_", FORMATS)
def test_file_with_other_contents_is_overwritten_only_on_request(
    format_: str, tmp_path: Path
) -> None:
    robot = one_link(muscles=[cable((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))])
    file = convert(robot, format_, tmp_path).files[0]
    assert convert(robot, format_, tmp_path).files[0] == file  # equal contents are no conflict
    written = file.read_bytes()
    file.write_bytes(b"notes of a user")
    with pytest.raises(InputError, match="already exists with other contents") as caught:
        convert(robot, format_, tmp_path)
    assert caught.value.file == file
    assert file.read_bytes() == b"notes of a user"
    convert(robot, format_, tmp_path, overwrite=True)
    assert file.read_bytes() == written


@pytest.mark.parametrize("name", ["a/b", "..\\a", "n" * 201])
@pytest.mark.parametrize("format_", FORMATS)
def test_invalid_file_name_is_reported_as_error(format_: str, name: str, tmp_path: Path) -> None:
    robot = replace(one_link(), name=name)
    if not FORMATS[format_].is_named:
        assert convert(robot, format_, tmp_path / "out").files
        return
    assert "file-name" in [f.code for f in losses_in(FORMATS[format_], robot) if f.is_error]
    with pytest.raises(RobotError, match="rename it"):
        convert(robot, format_, tmp_path / "out")
    assert not (tmp_path / "out").exists()
