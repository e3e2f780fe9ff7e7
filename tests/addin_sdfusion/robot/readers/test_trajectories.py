from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from addin_sdfusion.robot import InputError, TrajectoryPoint, UnknownNameError
from addin_sdfusion.robot.formats.read import read_trajectories, read_trajectory, trajectory_names

EXAMPLE = Path(__file__).parents[4] / "examples/planar_2r/robot/planar_2r_trajectories.xml"
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


def test_example_motion_returns_after_eight_seconds():
    check_simple_joint_motion(EXAMPLE)
    assert trajectory_names(EXAMPLE) == ("simple_joint_motion", "cubic_swing", "linear_sweep")


def test_original_motion_is_the_same(shared):
    folder = shared / "robots/caspr/Example_2R_planar_XZ"
    file = folder / "Example_2R_planar_XZ_trajectories.xml"
    check_simple_joint_motion(file)
    for name in trajectory_names(file):
        assert read_trajectory(file, name).points[0].time == 0.0


def test_relative_times_are_summed_and_absolute_times_are_not(tmp_path):
    points = [point("0", 7), point("1", 2), point("2", 3)]
    assert times(file_with(tmp_path, linear(*points))) == [0, 2, 5]
    assert times(file_with(tmp_path, linear(*points, definition="absolute"))) == [0, 2, 3]


def test_unknown_name_suggests_nearest_name():
    with pytest.raises(UnknownNameError, match="did you mean 'simple_joint_motion'"):
        read_trajectory(EXAMPLE, "simple_joint_moton")


TWO = (point("0"), point("1", 1))


def average(*points):
    tag = "cubic_spline_average_velocity_trajectory"
    return linear(*points).replace("linear_spline_trajectory", tag)


def rates(q_dot):
    return f"<q_dot>{q_dot}</q_dot>"


def test_inner_velocities_are_means_of_adjacent_slopes(tmp_path):
    ends = (point("0 0", more=rates("7 0")), point("9 1", 2, rates("0 8")))
    inner = (point("1 4", 1, rates("99 99")), point("3 0", 4))
    trajectory = read_trajectory(file_with(tmp_path, average(ends[0], *inner, ends[1])), "t")
    assert trajectory.spline == "cubic"
    assert [p.qd for p in trajectory.points] == [
        (7.0, 0.0),
        ((1.0 + 0.5) / 2, (4.0 - 1.0) / 2),
        ((0.5 + 3.0) / 2, (-1.0 + 0.5) / 2),
        (0.0, 8.0),
    ]


def blended(*points, default='blend_time_default="0.5"'):
    text = linear(*points).replace("linear_spline_trajectory", "parabolic_blend_trajectory")
    return text.replace('time_step="0.1"', f'time_step="0.1" {default}')


def slow(q, time, blend):
    return point(q, time).replace("<point", f'<point blend_time="{blend}"')


def test_blend_time_belongs_to_the_segment_before_its_point(tmp_path):
    file = file_with(tmp_path, blended(point("0"), point("1", 2), slow("2", 4, 1.5)))
    trajectory = read_trajectory(file, "t")
    assert trajectory.spline == "parabolic_blend"
    assert [(p.time, p.blend_time) for p in trajectory.points] == [(0, 0), (2, 0.5), (6, 1.5)]


def operational(*points, tag="linear"):
    text = linear(*points, tag=tag).replace("<q", "<y").replace("</q", "</y")
    return f"</joint_trajectories><operational_trajectories>\n{text}\n</operational_trajectories>\
<joint_trajectories>"


def test_operational_trajectories_have_separate_space_and_names(tmp_path):
    text = operational(point("0 1 2", more=rates("1 1 1")), point("1", 1), tag="cubic")
    text = text.replace("<y>1</y>", "<y>3 4 5</y><y_dot>0 0 0</y_dot>")
    file = file_with(tmp_path, text)
    assert (trajectory_names(file), trajectory_names(file, "operational")) == ((), ("t",))
    trajectory = read_trajectory(file, "t", "operational")
    assert (trajectory.space, trajectory.spline) == ("operational", "cubic")
    assert trajectory.points[1] == TrajectoryPoint(1.0, (3.0, 4.0, 5.0), (0.0, 0.0, 0.0))
    with pytest.raises(InputError, match="'t' is in operational space, not in joint space"):
        read_trajectory(file, "t")


SAMPLES = ["time_step,0.5", "t,0.0,p,1,2,v,3,4,a,5,6", "t,0.5,p,-1e-3,2,v,0,0,a,0,0"]
FILE = '<file_trajectory id="t" filename="t.traj"/>'


def test_samples_are_read_from_the_file_next_to_the_trajectories(tmp_path):
    (tmp_path / "t.traj").write_text("\r\n".join(SAMPLES) + "\r\n\r\n")
    trajectory = read_trajectory(file_with(tmp_path, FILE), "t")
    assert (trajectory.spline, trajectory.time_step) == ("samples", 0.5)
    assert trajectory.points == (
        TrajectoryPoint(0.0, (1.0, 2.0), (3.0, 4.0), (5.0, 6.0)),
        TrajectoryPoint(0.5, (-1e-3, 2.0), STILL, STILL),
    )


@pytest.mark.parametrize(
    ("line", "text", "message"),
    [
        (0, "", "first line must be 'time_step,<seconds>'"),
        (0, "time_step,soon", "'soon' is not a finite number"),
        (0, "time_step,0", "time_step must be positive"),
        (1, "t,0.1,p,1,2,v,3,4,a,5,6", r"time 0\.1 s must be 0\.0 s"),
        (2, "t,0.500001,p,1,2,v,3,4,a,5,6", r"must be 0\.5 s"),
        (2, "t,0.5,p,1,2,3,v,3,4,5,a,5,6,7", "'p' must have 2 numbers, not 3"),
        (2, "t,0.5,p,1,2,v,3,a,5,6", "'v' must have 2 numbers, not 1"),
        (2, "t,0.5,p,1,2,v,3,nan,a,5,6", "'nan' is not a finite number"),
        (2, "t,0.5,p,1,2,v,3,\x1f4,a,5,6", "is not a finite number"),
        (2, "t,0.5,p,1,2,v,3,4", "is not 't,<time>,p,"),
        (2, "t,0.5,p,1,2,v,3,4,a,5,6,t,7", "is not 't,<time>,p,"),
        (2, "0.5,t,p,1,2,v,3,4,a,5,6", "is not 't,<time>,p,"),
    ],
)
def test_invalid_sample_is_rejected_with_file_and_line(tmp_path, line, text, message):
    lines = [text if i == line else given for i, given in enumerate(SAMPLES)]
    (tmp_path / "t.traj").write_text("\n".join(lines))
    with pytest.raises(InputError, match=message) as caught:
        read_trajectory(file_with(tmp_path, FILE), "t")
    assert (caught.value.file, caught.value.line) == (tmp_path / "t.traj", line + 1)


def test_samples_require_two_lines_and_a_limited_file_size(tmp_path):
    (tmp_path / "t.traj").write_text("\n".join(SAMPLES[:2]))
    file = file_with(tmp_path, FILE)
    with pytest.raises(InputError, match="two samples"):
        read_trajectory(file, "t")
    with (tmp_path / "t.traj").open("wb") as stream:
        stream.truncate(2**25)
    with pytest.raises(InputError, match="larger than"):
        read_trajectory(file, "t")


@pytest.mark.parametrize("name", ["", "../t.traj", "/etc/passwd", ".", "C:\\..\\x"])
def test_sample_file_outside_the_folder_is_rejected(tmp_path, name):
    file = file_with(tmp_path, FILE.replace("t.traj", name))
    with pytest.raises(InputError, match=r"must be relative to this folder, without '\.\.'"):
        read_trajectory(file, "t")


def test_missing_sample_file_is_rejected(tmp_path):
    file = file_with(tmp_path, FILE.replace("t.traj", "none.traj"))
    with pytest.raises(InputError, match=r"file 'none\.traj' does not exist"):
        read_trajectory(file, "t")


@pytest.mark.parametrize(
    ("element", "line", "message"),
    [
        (linear(point("0 0"), point("1", 1)), 4, "must contain 2 numbers, not 1"),
        (linear(point("0"), point("nan", 1)), 4, "not a finite number"),
        (linear(point("0"), point("1e999", 1)), 4, "not a finite number"),
        (linear(point("0"), point("", 1)), 4, "must contain 1 numbers, not 0"),
        (linear(point("0"), point("1", 0)), 4, "must be greater than"),
        (linear(point("0"), point("1", -1)), 4, "must be greater than"),
        (linear(*TWO, point("2", 1), definition="absolute"), 5, "must be greater than"),
        (linear(point("0"), point("1")), 4, "no 'time'"),
        (linear(point("0"), "<point time='1'/>"), 4, "no <q>"),
        (linear(point("0")), 2, "must have at least two points, not"),
        (linear(*TWO, definition="sometimes"), 2, "must be 'relative' or 'absolute'"),
        (linear(*TWO, step="0"), 2, "time_step must be positive"),
        (linear(*TWO, step="x"), 2, "not a finite number"),
        (linear(*TWO, tag="cubic"), 3, "no <q_dot>"),
        (linear(*TWO, tag="odd"), 2, "unsupported <odd_spline_trajectory>"),
        (linear(*TWO) + "\n" + linear(*TWO), 6, "trajectory 't' appears twice"),
        (average(point("0"), point("1", 1, rates("0"))), 3, "no <q_dot>"),
        (
            average(*[point("0", 1, rates("0"))] * 2, point("0", 0, rates("0"))),
            5,
            "must be greater than",
        ),
        (
            average(point("0", 0, rates("0")), "<point time='1'/>", point("0", 2, rates("0"))),
            4,
            "<q>",
        ),
        (
            blended(point("0"), point("1", 1)),
            4,
            r"blend time 0\.5 s must be positive and less than half",
        ),
        (blended(point("0"), slow("1", 1, 0)), 4, r"blend time 0\.0 s must be positive"),
        (
            blended(slow("0", 0, 0.1), point("1", 2)),
            3,
            "blend_time of the first point has no segment",
        ),
        (blended(point("0"), point("1", 2), default=""), 2, "no 'blend_time_default'"),
        ("<file_trajectory id='t'/>", 2, "filename"),
    ],
)
def test_invalid_trajectory_is_rejected_with_file_and_line(tmp_path, element, line, message):
    file = file_with(tmp_path, element)
    with pytest.raises(InputError, match=message) as caught:
        read_trajectory(file, "t")
    assert (caught.value.file, caught.value.line) == (file, line)
    assert "\n" not in str(caught.value)


def test_file_of_another_kind_is_rejected(tmp_path):
    file = tmp_path / "x.xml"
    file.write_text("<cables/>")
    with pytest.raises(InputError, match="is not CASPR's <trajectories>"):
        trajectory_names(file)


@pytest.mark.parametrize("is_folder", [False, True])
def test_linked_samples_outside_the_folder_are_rejected(tmp_path, is_folder):
    """They would be copied from an untrusted robot into FMUs and results."""
    (tmp_path / "private").mkdir()
    (tmp_path / "private/t.traj").write_text("\n".join(SAMPLES))
    (tmp_path / "robot").mkdir()
    file = file_with(tmp_path / "robot", FILE.replace("t.traj", "in/t.traj") if is_folder else FILE)
    link = tmp_path / "robot" / ("in" if is_folder else "t.traj")
    link.symlink_to(tmp_path / ("private" if is_folder else "private/t.traj"))
    with pytest.raises(InputError, match="a link to a file outside this folder"):
        read_trajectory(file, "t")
    link.unlink()
    shutil.copytree(tmp_path / "private", tmp_path / "robot/in")
    shutil.copy(tmp_path / "private/t.traj", tmp_path / "robot")
    assert read_trajectory(file, "t").spline == "samples"


def test_linked_trajectories_file_outside_the_folder_is_omitted(tmp_path):
    (tmp_path / "private").mkdir()
    elsewhere = file_with(tmp_path / "private", FILE)
    (tmp_path / "robot").mkdir()
    (tmp_path / "robot/x_trajectories.xml").symlink_to(elsewhere)
    trajectories, (finding,) = read_trajectories(tmp_path / "robot/x_bodies.xml")
    assert trajectories == []
    assert "outside this folder" in finding.message
