"""External loads along a recorded motion, and the part of the motion that is analysed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.command_line import CommandLine
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import read_robot
from cardsflow_fmu.results.analysis.redundancy.loads import add_external_loads
from cardsflow_fmu.results.analysis.redundancy.motion import read_given_motion
from cardsflow_fmu.utils.csv_table import read_csv
from cardsflow_fmu.utils.opensim_table import opensim_text, read_opensim_table
from sim_dart.dynamics.link_motion import link_motion

ARM = EXAMPLES / "hill_arm/robot"
LOADS = """<OpenSimDocument><ExternalLoads><objects><ExternalForce name="hand">
<applied_to_body>{link}</applied_to_body><force_expressed_in_body>{body}</force_expressed_in_body>
<force_identifier>{force}</force_identifier><point_identifier>p</point_identifier>
<torque_identifier>m</torque_identifier></ExternalForce></objects>
<datafile>{data}</datafile></ExternalLoads></OpenSimDocument>"""
GOOD = {"link": "forearm", "body": "ground", "force": "f", "data": "loads.mot"}


def write_loads(folder: Path, end: float = 3.0, **changes: str) -> Path:
    """Write loads with a constant force, point and moment in the world."""
    t = np.array([0.0, end])
    values = np.tile([1.0, -2.0, 3.0, 0.1, 0.2, -0.4, 0.3, 0.5, -0.7], (2, 1))
    names = ["time", *(f"{kind}{axis}" for kind in "fpm" for axis in "xyz")]
    (folder / "loads.mot").write_text(opensim_text("loads", names, np.column_stack([t, values])))
    (folder / "loads.xml").write_text(LOADS.format(**(GOOD | changes)))
    return folder / "loads.xml"


def write_motion(folder: Path, columns: int | None = None) -> Path:
    robot = read_robot(ARM)
    t = np.linspace(0.0, 2.0, 21)
    names = [c.name for c in robot.coordinates][:columns]
    rows = [t, *(0.2 * np.sin(t + k) ** 2 for k in range(len(names)))]
    (folder / "m.sto").write_text(opensim_text("m", ["time", *names], np.column_stack(rows)))
    return folder / "m.sto"


def test_loads_have_the_power_of_the_wrench(tmp_path: Path) -> None:
    """By the differences of the position of the loaded point, and of the rotation of the link."""
    robot = read_robot(ARM)
    given = read_given_motion(robot, write_motion(tmp_path), 0.0, frames=3)
    loaded = add_external_loads(given, write_loads(tmp_path, link=robot.links[-1].name))
    assert loaded.loads is not None
    force, point, moment = np.array([1.0, -2, 3]), np.array([0.1, 0.2, -0.4]), [0.3, 0.5, -0.7]
    for k, q in enumerate(given.motion.q):
        own = [
            link_motion(robot, [robot.links[-1].name], *([q + step] for _ in range(3)))
            for step in (*1e-6 * np.eye(len(q)), *-1e-6 * np.eye(len(q)), np.zeros(len(q)))
        ]
        R, o = own[-1].rotations[0, 0], own[-1].origins[0, 0]
        for j in range(len(q)):
            plus, minus = own[j], own[j + len(q)]
            dR = (plus.rotations - minus.rotations)[0, 0] / 2e-6
            do = (plus.origins - minus.origins)[0, 0] / 2e-6
            spin = dR @ R.T
            w = np.array([spin[2, 1], spin[0, 2], spin[1, 0]])
            power = force @ (do + np.cross(w, point - o)) + moment @ w
            assert loaded.loads.generalised[k, j] == pytest.approx(power, abs=1e-8)
    np.testing.assert_array_equal(loaded.motion.w_e, -loaded.loads.generalised)


def test_link_accelerations_are_derivatives_of_positions() -> None:
    robot = read_robot(ARM)
    n, h = len(robot.coordinates), 1e-4
    t = np.array([-h, 0.0, h])[:, None] * np.ones(n)
    q, qd, qdd = 0.3 + t + t**2, 1.0 + 2.0 * t, np.full_like(t, 2.0)
    own = link_motion(robot, [link.name for link in robot.links], q, qd, qdd)
    expected = np.diff(own.points, 2, axis=0)[0] / h**2
    np.testing.assert_allclose(own.accelerations[1], expected, atol=1e-5)


def test_missing_coordinates_are_locked_with_a_note(tmp_path: Path, cardsflow: CommandLine) -> None:
    file = write_motion(tmp_path, 1)
    words = ("activations", ARM, "--motion", file, "--noise", 0, "--frames", 4, "-o")
    code, out, err = cardsflow(*words, tmp_path / "out")
    second = read_robot(ARM).coordinates[1]
    assert f"locked: {second.name} = {second.initial:g}" in err
    assert (code, out.splitlines()[0]) == (0, "4 points from 0 to 2 s")


WRONG = {
    "begin": (["--begin", "-1"], {}, "--begin: must be within the motion, 0 to 2 s, not -1"),
    "end": (["--end", "9"], {}, "--end: must be within the motion"),
    "frames": (["--frames", "1"], {}, "--frames: must be from 2 to 10000, not 1"),
    "empty": (["--begin", "1.01", "--end", "1.05"], {}, "contains no two rows from 1.01 to 1.05"),
    "link": ([], {"link": "hoof"}, "no link 'hoof'"),
    "body": ([], {"body": "pelvis"}, "express the load in ground"),
    "column": ([], {"force": "g"}, "no column 'gx'"),
    "data": ([], {"data": "other.mot"}, "other.mot"),
    "short": ([], {"end": 1.0}, "has loads from 0 to 1 s, but the motion is from 0 to 2 s"),
}


@pytest.mark.parametrize("case", WRONG)
def test_invalid_input_is_reported_in_one_line(
    case: str, tmp_path: Path, cardsflow: CommandLine
) -> None:
    options, changes, message = WRONG[case]
    changes = {"link": read_robot(ARM).links[-1].name} | changes
    loads, motion = write_loads(tmp_path, **changes), write_motion(tmp_path)
    words = ["activations", ARM, "--motion", motion, "--loads", loads, *options]
    assert message in cardsflow.error_line(*words, "-o", tmp_path / "out")


def test_dynamics_writes_excitations_and_fibres(tmp_path: Path, cardsflow: CommandLine) -> None:
    words = ("activations", ARM, "--motion", write_motion(tmp_path), "--dynamics", "--frames", 30)
    code, out, err = cardsflow(*words, "-o", tmp_path / "out")
    assert (code, err) == (0, "")
    assert out.splitlines()[1].startswith("cost ")
    table = read_opensim_table(tmp_path / "out/excitations.sto")
    assert table.names == ("time", *(m.name for m in read_robot(ARM).muscles))
    assert (table.rows[:, 1:] >= 0.0).all()
    assert (table.rows[:, 1:] <= 1.0).all()
    assert (tmp_path / "out/fibre_lengths.sto").is_file()
    names, rows = read_csv(tmp_path / "out/results.csv")
    columns = dict(zip(names, rows.T, strict=True))
    power = sum(columns[f"power.{m.name}"] for m in read_robot(ARM).muscles)
    reserve = sum(columns[f"reserve.{c.name}"] for c in read_robot(ARM).coordinates)
    assert abs(reserve).max() < 1.0
    assert abs(power).max() > 0.01
    assert (columns["umberger_2010.total"] > columns["power.biceps"]).all()
    assert np.isfinite(columns["reaction_force.elbow.z"]).all()
    page = tmp_path / "replay.html"
    assert cardsflow(*words, "-o", tmp_path / "out", "--html", page)[0] == 0
    assert page.is_file()


DYNAMICS = {
    "power": (["--power", "3"], ARM, "--power: requires --dynamics"),
    "low power": (["--dynamics", "--power", "1"], ARM, "--power: must be above 1"),
    "reserve": (["--dynamics", "--reserve", "0"], ARM, "--reserve: must be positive"),
    "passive": (["--dynamics", "--passive"], ARM, "--passive: is for static optimisation"),
    "frames": (["--dynamics", "--frames", "402"], ARM, "--frames: must be from 3 to 401"),
    "law": (["--dynamics"], EXAMPLES / "planar_2r/robot", "--dynamics does not support 'ideal'"),
}


@pytest.mark.parametrize("case", DYNAMICS)
def test_invalid_options_of_dynamics_are_reported_in_one_line(
    case: str, tmp_path: Path, cardsflow: CommandLine
) -> None:
    options, robot, message = DYNAMICS[case]
    t = np.linspace(0.0, 2.0, 21)
    names = ["time", *(c.name for c in read_robot(robot).coordinates)]
    rows = np.column_stack([t, *(0.1 * np.sin(t + k) for k in range(len(names) - 1))])
    (tmp_path / "m.sto").write_text(opensim_text("m", names, rows))
    words = ("activations", robot, "--motion", tmp_path / "m.sto", *options)
    assert message in cardsflow.error_line(*words, "-o", tmp_path / "out")
