from __future__ import annotations

import tempfile
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.robots.random_robots import numbers, robots

from addin_sdfusion.robot import (
    InputError,
    RobotError,
    Trajectory,
    TrajectoryPoint,
    read_robot,
    revolute,
    write_caspr,
    write_sdf,
)
from addin_sdfusion.robot.formats.read import read_trajectory, trajectory_names

EXAMPLE = Path(__file__).parents[4] / "examples/planar_2r/robot"


@pytest.fixture
def robot():
    return read_robot(EXAMPLE)


@pytest.mark.slow
@given(robots())
def test_sdf_restores_the_robot_exactly(robot):
    with tempfile.TemporaryDirectory() as folder:
        write_sdf(robot, folder)
        assert read_robot(folder) == robot
        assert read_robot(Path(folder) / "model.sdf") == robot


@pytest.mark.slow
@given(robots(caspr=True))
def test_caspr_restores_the_robot_exactly(robot):
    with tempfile.TemporaryDirectory() as folder:
        write_caspr(robot, folder)
        assert read_robot(folder) == robot


@pytest.mark.slow
@given(robots())
def test_cardsflow_xml_restores_active_muscles_and_task_frames(robot):
    with tempfile.TemporaryDirectory() as folder:
        write_sdf(robot, folder)
        sdf = Path(folder) / "model.sdf"
        text = sdf.read_text(encoding="utf-8")
        start, end = text.index("<plugin"), text.index("</plugin>")
        sdf.write_text(text[:start] + text[end + len("</plugin>") :], encoding="utf-8")
        again = read_robot(folder)
        assert again.muscles == robot.muscles
        assert again.task_frames == robot.task_frames


PARTS = {"linear": 1, "cubic": 2, "quintic": 3, "parabolic_blend": 1, "samples": 3}


@st.composite
def trajectories(draw):
    spline = draw(st.sampled_from(list(PARTS)))
    times = [0.0, *draw(st.lists(st.floats(0.001, 1e3), min_size=1, max_size=4, unique=True))]
    times.sort()
    time_step = draw(st.floats(1e-6, 1.0))
    if spline == "samples":
        times = [k * time_step for k in range(len(times))]
    values = st.tuples(numbers, numbers)
    points = []
    for before, time in pairwise([0.0, *times]):
        rows = [draw(values) for _ in range(PARTS[spline])]
        half = (time - before) / 2.0
        blended = spline == "parabolic_blend" and time > 0.0
        blend = draw(st.floats(half / 10.0, half * 0.9)) if blended else 0.0
        points.append(replace(TrajectoryPoint(time, *rows), blend_time=blend))
    space = draw(st.sampled_from(["joint", "operational"]))
    return Trajectory("t", spline, tuple(points), time_step, space)


@pytest.mark.slow
@given(trajectories())
def test_trajectories_are_restored_exactly(trajectory):
    with tempfile.TemporaryDirectory() as folder:
        write_caspr(read_robot(EXAMPLE), folder, trajectories=[trajectory])
        file = Path(folder) / "planar_2r_trajectories.xml"
        assert trajectory_names(file, trajectory.space) == ("t",)
        assert read_trajectory(file, "t", trajectory.space) == trajectory


def test_example_files_equal_the_output_of_the_writer(robot, tmp_path):
    file = EXAMPLE / "planar_2r_trajectories.xml"
    stored = [read_trajectory(file, name) for name in trajectory_names(file)]
    for written in write_caspr(robot, tmp_path, trajectories=stored):
        assert written.read_bytes() == (EXAMPLE / written.name).read_bytes()


def test_robot_is_unchanged_from_caspr_to_sdf(robot, tmp_path):
    write_sdf(robot, tmp_path)
    assert read_robot(tmp_path) == robot


def test_writing_creates_only_the_returned_files(robot, tmp_path):
    folder = tmp_path / "new" / "folder"
    assert sorted(write_sdf(robot, folder)) == sorted(folder.iterdir())


def test_output_folder_that_is_a_file_is_rejected_in_one_line(robot, tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(InputError, match=r"taken: cannot be written: [^\n]+$"):
        write_sdf(robot, tmp_path / "taken")


def with_joint(robot, **changes):
    return replace(robot, joints=(robot.joints[0], replace(robot.joints[1], **changes)))


@pytest.mark.parametrize("name", ["link_1", "a::b", "__a__"])
def test_sdf_rejects_repeated_and_reserved_names(robot, tmp_path, name):
    coordinate = replace(robot.coordinates[1], name=name)
    with pytest.raises(InputError, match=name):
        write_sdf(with_joint(robot, name=name, coordinates=(coordinate,)), tmp_path)


def test_invalid_robot_is_not_written(robot, tmp_path):
    broken = with_joint(robot, motions=revolute((0.0, 0.0, 0.0)))
    with pytest.raises(RobotError, match="axis is zero"):
        write_sdf(broken, tmp_path)
    with pytest.raises(RobotError, match="axis is zero"):
        write_caspr(broken, tmp_path)
