from __future__ import annotations

from pathlib import Path

import pytest

from addin_sdfusion.robot import InputError, TrajectoryPoint, UnknownNameError
from addin_sdfusion.robot.readers import read_trajectory, trajectory_names

EXAMPLE = Path(__file__).parents[3] / "examples/planar_2r/robot/planar_2r_trajectories.xml"
STILL = (0.0, 0.0)


def file_with(folder, element):
    file = folder / "robot_trajectories.xml"
    text = f"<trajectories><joint_trajectories>\n{element}\n</joint_trajectories></trajectories>"
    file.write_text(text)
    return file


def linear(*points, definition="relative", step="0.1", tag="linear"):
    return (
        f'<{tag}_spline_trajectory id="t" time_definition="{definition}" time_step="{step}">'
        f"<points>\n{chr(10).join(points)}\n</points></{tag}_spline_trajectory>"
    )


def point(q, time=None, more=""):
    attribute = "" if time is None else f' time="{time}"'
    return f"<point{attribute}><q>{q}</q>{more}</point>"


def times(file):
    return [p.time for p in read_trajectory(file, "t").points]


def check_simple_joint_motion(file):
    trajectory = read_trajectory(file, "simple_joint_motion")
    assert (trajectory.spline, trajectory.time_step) == ("quintic", 0.01)
    assert trajectory.points == (
        TrajectoryPoint(0.0, (-0.5, 0.5), STILL, STILL),
        TrajectoryPoint(4.0, (0.5, -0.5), STILL, STILL),
        TrajectoryPoint(8.0, (-0.5, 0.5), STILL, STILL),
    )


def test_the_motion_of_the_example_goes_there_and_back_in_eight_seconds():
    check_simple_joint_motion(EXAMPLE)
    assert trajectory_names(EXAMPLE) == ("simple_joint_motion", "cubic_swing", "linear_sweep")


def test_the_motion_of_the_original_file_is_the_same(shared):
    folder = shared / "robots/caspr/Example_2R_planar_XZ"
    file = folder / "Example_2R_planar_XZ_trajectories.xml"
    check_simple_joint_motion(file)
    for name in trajectory_names(file):
        assert read_trajectory(file, name).points[0].time == 0.0


def test_relative_times_add_up_and_absolute_ones_do_not(tmp_path):
    points = [point("0", 7), point("1", 2), point("2", 3)]
    assert times(file_with(tmp_path, linear(*points))) == [0, 2, 5]
    assert times(file_with(tmp_path, linear(*points, definition="absolute"))) == [0, 2, 3]


def test_an_unknown_name_is_answered_with_the_nearest_one():
    with pytest.raises(UnknownNameError, match="did you mean 'simple_joint_motion'"):
        read_trajectory(EXAMPLE, "simple_joint_moton")


TWO = (point("0"), point("1", 1))


@pytest.mark.parametrize(
    ("element", "line", "message"),
    [
        (linear(point("0 0"), point("1", 1)), 4, "has 1 numbers, not 2"),
        (linear(point("0"), point("nan", 1)), 4, "not a finite number"),
        (linear(point("0"), point("1e999", 1)), 4, "not a finite number"),
        (linear(point("0"), point("", 1)), 4, "has 0 numbers, not 1"),
        (linear(point("0"), point("1", 0)), 4, "does not come after"),
        (linear(point("0"), point("1", -1)), 4, "does not come after"),
        (linear(*TWO, point("2", 1), definition="absolute"), 5, "does not come after"),
        (linear(point("0"), point("1")), 4, "no 'time'"),
        (linear(point("0"), "<point time='1'/>"), 4, "no <q>"),
        (linear(point("0")), 2, "needs two points"),
        (linear(*TWO, definition="sometimes"), 2, "neither 'relative' nor 'absolute'"),
        (linear(*TWO, step="0"), 2, "time_step is not above zero"),
        (linear(*TWO, step="x"), 2, "not a finite number"),
        (linear(*TWO, tag="cubic"), 3, "no <q_dot>"),
        (linear(*TWO, tag="odd"), 2, "<odd_spline_trajectory> is not supported"),
        (linear(*TWO) + "\n" + linear(*TWO), 6, "a second trajectory 't'"),
    ],
)
def test_a_broken_trajectory_is_refused_with_file_and_line(tmp_path, element, line, message):
    file = file_with(tmp_path, element)
    with pytest.raises(InputError, match=message) as caught:
        read_trajectory(file, "t")
    assert (caught.value.file, caught.value.line) == (file, line)
    assert "\n" not in str(caught.value)


def test_a_file_of_another_kind_is_refused(tmp_path):
    file = tmp_path / "x.xml"
    file.write_text("<cables/>")
    with pytest.raises(InputError, match="is not CASPR's <trajectories>"):
        trajectory_names(file)
