"""The commands in the README of the example convert a design snapshot and run it."""

from __future__ import annotations

import json
import shlex
import shutil
from pathlib import Path

import numpy as np
import pytest
from support.documents import NOT_RUN, blocks
from support.robots.robots import EXAMPLES, planar_2r

from addin_sdfusion.robot import read_robot
from cardsflow_fmu.cli.main import main
from sim_dart import DartDynamics

GOOD_ERROR = 5e-4
"""Maximum tracking error of the test run of an imported design, in [rad]."""
README = EXAMPLES / "from_cad/README.md"
COMMANDS = [
    line
    for block in blocks(README)
    if block.language == "sh" and block.argument(NOT_RUN) is None
    for line in block.text.splitlines()
    if line
]


@pytest.mark.slow
def test_commands_convert_a_design_to_a_replay_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copytree(EXAMPLES / "from_cad", "examples/from_cad")
    shutil.copytree(EXAMPLES / "planar_2r", "examples/planar_2r")
    for command in COMMANDS:
        assert main(shlex.split(command)[1:]) == 0, command
    assert len(COMMANDS) == 7
    assert tracking_error(Path("roboy_results")) < GOOD_ERROR
    assert tracking_error(Path("results")) < GOOD_ERROR
    by_hand = 8.2e-6  # tracking error of the hand-written example
    assert tracking_error(Path("moved")) == pytest.approx(by_hand, rel=0.01)
    assert "</html>" in Path("arm.html").read_text(encoding="utf-8")


def tracking_error(results: Path) -> float:
    """Return the RMS tracking error of a run without infeasible ticks, in [rad]."""
    summary = json.loads((results / "summary.json").read_text(encoding="utf-8"))
    assert (summary["status"], summary["infeasible_ticks"]) == ("complete", 0)
    return float(summary["tracking"]["rms"])


def test_drawn_left_arm_equals_the_arm_of_roboy(tmp_path: Path) -> None:
    """Compare M, L, l, J and G at random poses within the limits."""
    snapshot = EXAMPLES / "from_cad/roboy_left_arm.json"
    assert main(["import-cad", str(snapshot), "-o", str(tmp_path / "arm")]) == 0
    robot, example = (read_robot(f) for f in (tmp_path / "arm", EXAMPLES / "roboy_left_arm/robot"))
    assert [m.name for m in robot.muscles] == [m.name for m in example.muscles]
    assert len(robot.muscles) == 11
    limits = [(c.name, c.lower, c.upper) for c in example.coordinates]
    assert [(c.name, c.lower, c.upper) for c in robot.coordinates] == limits
    ours, theirs = DartDynamics(robot), DartDynamics(example)
    start = np.array([c.initial for c in example.coordinates])
    for q in start + np.random.default_rng(0).uniform(-0.5, 0.5, (10, 4)):
        for term in TERMS:
            found, expected = getattr(ours, term)(q), getattr(theirs, term)(q)
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9, err_msg=term)


TERMS = ("mass_matrix", "muscle_jacobian", "muscle_lengths", "task_jacobian", "gravity")


def test_robot_equals_the_hand_written_robot(tmp_path: Path) -> None:
    """Compare M, L, l, J and G at random poses, and the meshes in the link frames."""
    snapshot = EXAMPLES / "from_cad/two_link_arm.json"
    assert main(["import-cad", str(snapshot), "-o", str(tmp_path / "arm")]) == 0
    robot = read_robot(tmp_path / "arm")
    made, example = DartDynamics(robot), DartDynamics(planar_2r())
    for q in np.random.default_rng(0).uniform(-0.8, 0.8, (10, 2)):
        for term in TERMS:
            ours, theirs = getattr(made, term)(q), getattr(example, term)(q)
            np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-9, err_msg=term)
    for link in ("link_1", "link_2"):
        data = (tmp_path / f"arm/meshes/visual/{link}.stl").read_bytes()
        triangle = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("end", "<u2")])
        corners = np.frombuffer(data[84:], triangle)["corners"].reshape(-1, 3)
        assert (corners[:, 2].min(), corners[:, 2].max()) == (0.0, 1.0)
