"""`cardsflow check` and `convert`: losses of formats, trajectories."""

from __future__ import annotations

import json
import math
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from support.command_line import CommandLine
from support.robots.robots import EXAMPLES, planar_2r

from addin_sdfusion.robot import Motion, TaskFrame, TaskSet, read_robot, write_caspr, write_sdf
from addin_sdfusion.robot.formats.convert import FORMATS
from addin_sdfusion.robot.formats.read import read_trajectories

PLANAR_2R = Path(__file__).parents[3] / "examples/planar_2r/robot"
EVERY_KIND = """<trajectories>
<joint_trajectories>
<linear_spline_trajectory id="line" time_definition="relative" time_step="0.1"><points>
<point><q>0 0.5</q></point><point time="1"><q>0.1 0.2</q></point>
</points></linear_spline_trajectory>
<cubic_spline_trajectory id="cubic" time_definition="absolute" time_step="0.1"><points>
<point><q>0 0</q><q_dot>0.3 0</q_dot></point>
<point time="0.7"><q>1 1</q><q_dot>0 -1</q_dot></point>
</points></cubic_spline_trajectory>
<quintic_spline_trajectory id="quintic" time_definition="relative" time_step="0.01"><points>
<point><q>0 0</q><q_dot>0 0</q_dot><q_ddot>1 2</q_ddot></point>
<point time="2"><q>1 1</q><q_dot>0 0</q_dot><q_ddot>0 0</q_ddot></point>
</points></quintic_spline_trajectory>
<cubic_spline_average_velocity_trajectory id="mean" time_definition="relative" time_step="0.1">
<points><point><q>0 0</q><q_dot>0 0</q_dot></point><point time="1"><q>1 1</q></point>
<point time="3"><q>1 5</q><q_dot>1 0</q_dot></point>
</points></cubic_spline_average_velocity_trajectory>
<parabolic_blend_trajectory id="blend" time_definition="relative" time_step="0.1"
 blend_time_default="0.2"><points><point><q>0 0</q></point>
<point time="1"><q>1 1</q></point><point time="1" blend_time="0.3"><q>2 0</q></point>
</points></parabolic_blend_trajectory>
<file_trajectory id="file" filename="samples.traj"/>
</joint_trajectories>
<operational_trajectories>
<linear_spline_trajectory id="way" time_definition="relative" time_step="0.1"><points>
<point><y>0 0.5</y></point><point time="1"><y>0.1 0.2</y></point>
</points></linear_spline_trajectory>
<quintic_spline_trajectory id="curve" time_definition="relative" time_step="0.01"><points>
<point><y>0 0</y><y_dot>0 0</y_dot><y_ddot>1 2</y_ddot></point>
<point time="2"><y>1 1</y><y_dot>0 0</y_dot><y_ddot>0 0</y_ddot></point>
</points></quintic_spline_trajectory>
</operational_trajectories>
</trajectories>"""
SAMPLES = "time_step,0.5\nt,0,p,0,0,v,0,0,a,1,1\nt,0.5,p,1,1,v,0,0,a,0,2"


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    """Create the folder of the planar arm in CASPR format with a trajectory of every kind."""
    folder = tmp_path / "arm"
    shutil.copytree(PLANAR_2R, folder)
    (folder / "planar_2r_trajectories.xml").write_text(EVERY_KIND)
    (folder / "samples.traj").write_text(SAMPLES)
    return folder


def test_caspr_conversion_keeps_all_trajectories(
    arm: Path, tmp_path: Path, cardsflow: CommandLine
) -> None:
    made = cardsflow.json("convert", arm, "--to", "caspr", "-o", tmp_path / "made")
    assert {finding["code"] for finding in made["findings"]} == {"zero-inertia-about-axis"}
    before, unread = read_trajectories(arm / "planar_2r_bodies.xml")
    assert (len(before), unread) == (8, [])
    after, unread = read_trajectories(tmp_path / "made/planar_2r_bodies.xml")
    assert (after, unread) == (before, [])
    assert read_robot(tmp_path / "made") == read_robot(arm)


@pytest.mark.parametrize("format_", sorted(set(FORMATS) - {"caspr"}))
def test_other_formats_report_lost_trajectories(
    format_: str, arm: Path, tmp_path: Path, cardsflow: CommandLine
) -> None:
    made = cardsflow.json("convert", arm, "--to", format_, "-o", tmp_path / "made")
    (lost,) = [f for f in made["findings"] if f["code"] == "trajectories-left-out"]
    assert all(f"'{name}'" in lost["message"] for name in ("line", "mean", "file", "curve"))
    assert cardsflow.json("check", arm, "--for", format_) == made["findings"]


def test_muscles_are_written_as_a_table(tmp_path: Path, cardsflow: CommandLine) -> None:
    robot, file = EXAMPLES / "pneumatic_elbow/robot", tmp_path / "muscles.csv"
    made = cardsflow.json("convert", robot, "--to", file)
    assert made["files"] == [str(file)]
    assert [f["code"] for f in made["findings"]] == ["links-left-out"]
    assert file.read_text().startswith("role,name,number,frame,link,x [m]")


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ('<point time="0.7">', '<point time="0">', "must be greater than"),
        ("samples.traj", "nowhere.traj", "file 'nowhere.traj' does not exist"),
        ("<q>0 0</q><q_dot>0.3 0</q_dot>", "<q>0</q><q_dot>0</q_dot>", "must contain 1 numbers"),
        ('id="curve"', 'id="cubic"', "another trajectory has this name"),
        ("<q>0 0.5</q></point><point time=\"1\"><q>0.1 0.2</q>",
         "<q>0</q></point><point time=\"1\"><q>1</q>", "the robot has 2 coordinates; omitted"),
    ],
)  # fmt: skip
def test_invalid_trajectory_is_omitted_and_reported(
    old: str, new: str, what: str, arm: Path, tmp_path: Path, cardsflow: CommandLine
) -> None:
    (arm / "planar_2r_trajectories.xml").write_text(EVERY_KIND.replace(old, new))
    made = cardsflow.json("convert", arm, "--to", "caspr", "-o", tmp_path / "made")
    (lost,) = [finding for finding in made["findings"] if finding["kind"] == "trajectory"]
    assert lost["severity"] == "warning"
    assert what in lost["message"]
    assert lost["message"].endswith("; omitted")
    after, unread = read_trajectories(tmp_path / "made/planar_2r_bodies.xml")
    assert (len(after), unread) == (7, [])


def test_robot_with_unreadable_trajectories_is_converted(
    arm: Path, tmp_path: Path, cardsflow: CommandLine
) -> None:
    (arm / "planar_2r_trajectories.xml").write_text("<trajectories>")
    made = cardsflow.json("convert", arm, "--to", "caspr", "-o", tmp_path / "made")
    (lost,) = [finding for finding in made["findings"] if finding["kind"] == "trajectory"]
    assert lost["message"].endswith("; its trajectories are ignored")
    assert lost["file"] == str(arm / "planar_2r_trajectories.xml")
    assert read_robot(tmp_path / "made") == read_robot(arm)


@pytest.mark.slow
def test_trajectory_samples_above_16_mib_are_omitted(arm: Path) -> None:
    many = "".join(f'<file_trajectory id="t{k}" filename="samples.traj"/>' for k in range(9))
    text = f"<trajectories><joint_trajectories>{many}</joint_trajectories></trajectories>"
    (arm / "planar_2r_trajectories.xml").write_text(text)
    rows = [f"t,{0.5 * k},p,0,0,v,0,0,a,{k:0100d},1" for k in range(18000)]
    (arm / "samples.traj").write_text("\n".join(["time_step,0.5", *rows]))
    size = (arm / "samples.traj").stat().st_size
    trajectories, unread = read_trajectories(arm / "planar_2r_bodies.xml")
    assert len(trajectories) == 16 * 2**20 // size < 9
    assert {f.message.split(": ")[1] for f in unread} == {
        "the .traj files exceed 16 MiB in total; omitted"
    }


def test_all_unsupported_features_of_a_format_are_listed(
    tmp_path: Path, cardsflow: CommandLine
) -> None:
    """As the hint states, `check --for` lists all of them, and so does `convert`."""
    robot = replace(planar_2r(), gravity=(0.0, 0.0, 1.0))
    q = replace(robot.joints[1].coordinates[0], name="bend")
    motions = (*robot.joints[1].motions, Motion("rotation", (1.0, 0.0, 0.0), 1))  # about y, x
    wrist = replace(robot.joints[1], motions=motions, coordinates=(q, replace(q, name="turn")))
    robot = replace(robot, joints=(robot.joints[0], wrist))
    write_sdf(robot, tmp_path / "robot")
    code, out, err = cardsflow("convert", tmp_path / "robot", "--to", "caspr", "-o", tmp_path / "x")
    assert (code, out, (tmp_path / "x").exists()) == (2, "", False)
    *listed, message = err.splitlines()
    assert message.endswith("(and 1 more; `cardsflow check --for caspr` lists all)")
    code, out, _ = cardsflow("check", tmp_path / "robot", "--for", "caspr")
    assert code == 1
    assert set(listed) <= set(out.splitlines())
    assert sum("error: " in line for line in listed) == 2
    words = ("convert", tmp_path / "robot", "--to", "caspr", "-o", tmp_path / "x", "--json")
    code, out, _ = cardsflow(*words)
    assert code == 2
    assert len(json.loads(out)["findings"]) == len(listed)


def test_errors_of_a_robot_are_reported_before_format_losses(
    tmp_path: Path, cardsflow: CommandLine
) -> None:
    for file in write_caspr(planar_2r(), tmp_path):
        file.write_text(file.read_text().replace("<mass>", "<mass>-"))
    words = ("check", tmp_path, "--for", "sdf", "--motion", "random")
    code, out, _ = cardsflow(*words)
    assert code == 1
    assert out.splitlines()[-1].endswith("; --motion and --for skipped because of the errors")
    code, _, err = cardsflow("convert", tmp_path, "--to", "sdf", "-o", tmp_path / "made")
    assert code == 2
    assert err.count("is negative [") == 2
    assert "`cardsflow check` lists all" in err


def test_unknown_format_is_named(cardsflow: CommandLine) -> None:
    assert "no format 'xml'" in cardsflow.error_line("check", PLANAR_2R, "--for", "xml")


def test_inactive_set_is_reported_as_lost(tmp_path: Path, cardsflow: CommandLine) -> None:
    robot = planar_2r()
    other = TaskSet("other", (TaskFrame("elbow", "link_1"),))
    write_caspr(replace(robot, task_sets=(*robot.task_sets, other)), tmp_path)
    codes = [finding["code"] for finding in cardsflow.json("check", tmp_path, "--for", "mjcf")]
    assert "task-sets-left-out" in codes


def test_repeated_findings_are_one_line(tmp_path: Path, cardsflow: CommandLine) -> None:
    """Four muscles have no limit; a finding of another kind has its own line."""
    robot = planar_2r()
    endless = [replace(muscle, f_max=math.inf) for muscle in robot.muscles]
    write_sdf(robot.with_muscles(endless), tmp_path / "robot")
    code, out, _ = cardsflow("check", tmp_path / "robot")
    (line,) = [line for line in out.splitlines() if "no-force-limit" in line]
    assert "'cable_1': no maximum force" in line
    assert "and 3 more of this kind: 'cable_2', 'cable_3', 'cable_4' (list all: --verbose)" in line
    _, every, _ = cardsflow("check", tmp_path / "robot", "--verbose")
    assert every.count("no-force-limit") == 4
    assert code == 0
    assert every.splitlines()[-1] == out.splitlines()[-1]
    words = ("convert", tmp_path / "robot", "--to", "sdf", "-o", tmp_path / "again")
    assert cardsflow(*words)[2].count("no-force-limit") == 1
