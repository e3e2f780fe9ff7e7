from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from strategies import numbers, robots

from addin_sdfusion.robot import (
    InputError,
    Pose,
    RobotError,
    Trajectory,
    TrajectoryPoint,
    read_robot,
    revolute,
    write_caspr,
    write_sdf,
)
from addin_sdfusion.robot.readers import read_trajectory, trajectory_names

EXAMPLE = Path(__file__).parents[3] / "examples/planar_2r/robot"
slow = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])


@pytest.fixture
def robot():
    return read_robot(EXAMPLE)


@slow
@given(robots())
def test_sdf_gives_back_the_robot_to_the_last_bit(robot):
    with tempfile.TemporaryDirectory() as folder:
        write_sdf(robot, folder)
        assert read_robot(folder) == robot
        assert read_robot(Path(folder) / "model.sdf") == robot


@slow
@given(robots(caspr=True))
def test_caspr_gives_back_the_robot_to_the_last_bit(robot):
    with tempfile.TemporaryDirectory() as folder:
        write_caspr(robot, folder)
        assert read_robot(folder) == robot


@slow
@given(robots())
def test_cardsflow_xml_alone_gives_back_the_active_muscles_and_task_frames(robot):
    with tempfile.TemporaryDirectory() as folder:
        write_sdf(robot, folder)
        sdf = Path(folder) / "model.sdf"
        text = sdf.read_text(encoding="utf-8")
        start, end = text.index("<plugin"), text.index("</plugin>")
        sdf.write_text(text[:start] + text[end + len("</plugin>") :], encoding="utf-8")
        again = read_robot(folder)
        assert again.muscles == robot.muscles
        assert again.task_frames == robot.task_frames


@st.composite
def trajectories(draw):
    spline = draw(st.sampled_from(["linear", "cubic", "quintic"]))
    times = [0.0, *draw(st.lists(st.floats(0.001, 1e3), min_size=1, max_size=4, unique=True))]
    values = st.tuples(numbers, numbers)
    parts = {"linear": 1, "cubic": 2, "quintic": 3}[spline]
    points = [TrajectoryPoint(t, *(draw(values) for _ in range(parts))) for t in sorted(times)]
    return Trajectory("t", spline, tuple(points), draw(st.floats(1e-6, 1.0)))


@slow
@given(trajectories())
def test_trajectories_read_back_to_the_last_bit(trajectory):
    with tempfile.TemporaryDirectory() as folder:
        *_, file = write_caspr(read_robot(EXAMPLE), folder, trajectories=[trajectory])
        assert trajectory_names(file) == ("t",)
        assert read_trajectory(file, "t") == trajectory


def test_the_example_is_what_the_writer_makes_of_it(robot, tmp_path):
    file = EXAMPLE / "planar_2r_trajectories.xml"
    stored = [read_trajectory(file, name) for name in trajectory_names(file)]
    for written in write_caspr(robot, tmp_path, trajectories=stored):
        assert written.read_bytes() == (EXAMPLE / written.name).read_bytes()


def test_a_robot_goes_from_caspr_to_sdf_unchanged(robot, tmp_path):
    write_sdf(robot, tmp_path)
    assert read_robot(tmp_path) == robot


def test_writing_leaves_nothing_but_the_files_it_tells(robot, tmp_path):
    folder = tmp_path / "new" / "folder"
    assert sorted(write_sdf(robot, folder)) == sorted(folder.iterdir())


def test_writing_into_a_file_is_refused_in_one_line(robot, tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(InputError, match=r"taken: cannot be written: [^\n]+$"):
        write_sdf(robot, tmp_path / "taken")


def with_joint(robot, **changes):
    return replace(robot, joints=(robot.joints[0], replace(robot.joints[1], **changes)))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"motions": (), "coordinates": ()}, "no fixed joints.*'joint_2'"),
        ({"T_parent_joint": Pose(rpy=(0.1, 0.0, 0.0))}, "no turned frames.*'joint_2'"),
        ({"T_child_joint": Pose((0.1, 0.0, 0.0))}, "frame of link 'link_2'.*'joint_2'"),
    ],
)
def test_caspr_refuses_a_joint_that_it_cannot_hold_by_name(robot, tmp_path, changes, message):
    with pytest.raises(InputError, match=message):
        write_caspr(with_joint(robot, **changes), tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_caspr_refuses_damping_other_gravity_and_names_that_are_paths(robot, tmp_path):
    damped = replace(robot.joints[1].coordinates[0], damping=1.0)
    with pytest.raises(InputError, match="no damping: joint 'joint_2'"):
        write_caspr(with_joint(robot, coordinates=(damped,)), tmp_path)
    with pytest.raises(InputError, match="gravity"):
        write_caspr(replace(robot, gravity=(0.0, 0.0, 0.0)), tmp_path)
    with pytest.raises(InputError, match="file name"):
        write_caspr(robot, tmp_path, name="../robot")
    short = Trajectory("t", "linear", (TrajectoryPoint(0.0, (1.0,)),), 0.1)
    with pytest.raises(InputError, match="1 values a point; the robot has 2"):
        write_caspr(robot, tmp_path, trajectories=[short])


@pytest.mark.parametrize("name", ["link_1", "a::b", "__a__"])
def test_sdf_refuses_names_that_it_shares_or_reserves(robot, tmp_path, name):
    coordinate = replace(robot.coordinates[1], name=name)
    with pytest.raises(InputError, match=name):
        write_sdf(with_joint(robot, name=name, coordinates=(coordinate,)), tmp_path)


def test_sdf_refuses_a_coordinate_that_is_not_called_as_its_joint(robot, tmp_path):
    coordinate = replace(robot.coordinates[1], name="bend")
    with pytest.raises(InputError, match=r"'bend'.*'joint_2'"):
        write_sdf(with_joint(robot, coordinates=(coordinate,)), tmp_path)


def test_a_broken_robot_is_not_written(robot, tmp_path):
    broken = with_joint(robot, motions=revolute((0.0, 0.0, 0.0)))
    with pytest.raises(RobotError, match="axis is zero"):
        write_sdf(broken, tmp_path)
    with pytest.raises(RobotError, match="axis is zero"):
        write_caspr(broken, tmp_path)
