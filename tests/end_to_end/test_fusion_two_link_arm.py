"""The two-link arm is drawn in the fake Fusion, exported, and run like the example."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import fake_fusion
import numpy as np
import pytest
from fake_fusion import designs
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from support.process_output import files_of
from support.robots.robots import PLANAR_2R, planar_2r

from addin_sdfusion.building.build_robot import build_robot
from addin_sdfusion.exporting.export import export_robot
from addin_sdfusion.robot import Robot, read_robot
from addin_sdfusion.snapshot import DesignSnapshot
from addin_sdfusion.snapshot_file import read_snapshot, write_snapshot
from cardsflow_fmu import Experiment
from cardsflow_fmu.cli.main import main
from cardsflow_fmu.simulation.run import simulate
from sim_dart import DartDynamics

with fake_fusion.modules():
    from addin_sdfusion.fusion.design import read_design


def drawn(**how: object) -> DesignSnapshot:
    """Draw the arm with the given options and return the snapshot of the add-in."""
    with fake_fusion.install() as fake:
        return read_design(fake.activate(designs.two_link_arm(**how)) or fake.app, meshes=False)


def require_same_dynamics(robot: Robot, *, gravity: bool = True, tasks: bool = True) -> None:
    """Compare M, C, G, l, L and J with those of the example at random states."""
    made, example = DartDynamics(robot), DartDynamics(planar_2r())
    assert made.coordinate_names == example.coordinate_names
    assert made.muscle_names == example.muscle_names
    rng = np.random.default_rng(0)
    for q, qd in rng.uniform(-0.8, 0.8, (10, 2, 2)):
        terms = ["mass_matrix", "muscle_jacobian", "muscle_lengths"]
        for term in [*terms, "task_jacobian"] if tasks else terms:
            ours, theirs = getattr(made, term)(q), getattr(example, term)(q)
            np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-9, err_msg=term)
        np.testing.assert_allclose(made.coriolis(q, qd), example.coriolis(q, qd), atol=1e-9)
        if gravity:
            np.testing.assert_allclose(made.gravity(q), example.gravity(q), atol=1e-9)


@pytest.mark.slow
def test_exported_arm_tracks_like_the_example(tmp_path: Path) -> None:
    """Run the exported folder with the trajectory, gains and force limits of the example."""
    export_robot(drawn(), tmp_path / "arm")
    require_same_dynamics(read_robot(tmp_path / "arm"))
    assert main(["init", str(tmp_path / "arm"), "-o", str(tmp_path / "arm")]) == 0
    trajectories = PLANAR_2R / "robot/planar_2r_trajectories.xml"
    reference = f'reference={{trajectory="simple_joint_motion", file="{trajectories}"}}'
    controller = "controller={kp=2000.0, kd=90.0, period=0.001}"
    words = ["run", str(tmp_path / "arm"), "-o", str(tmp_path / "out")]
    assert main([*words, "--set", reference, "--set", controller, "--set", "run.duration=8.0"]) == 0
    result = simulate(
        Experiment.load(
            tmp_path / "arm",
            {
                "reference": {
                    "trajectory": "simple_joint_motion",
                    "file": str(trajectories),
                },
                "controller": {"kp": 2000.0, "kd": 90.0, "period": 0.001},
                "run.duration": 8.0,
            },
        ),
        coupling="direct",
    )
    summary = result.summary
    assert summary["tracking"]["rms"] < 1e-5
    assert summary["infeasible_ticks"] == 0
    assert summary["forces"]["min"] >= 10.0
    assert summary["forces"]["max"] < 41.5


@pytest.mark.slow
def test_exported_folder_runs_after_init(tmp_path: Path) -> None:
    export_robot(drawn(q=(0.3, -0.2)), tmp_path / "arm")
    assert main(["check", str(tmp_path / "arm")]) == 0
    assert main(["init", str(tmp_path / "arm"), "-o", str(tmp_path / "arm")]) == 0
    assert main(["run", str(tmp_path / "arm"), "-o", str(tmp_path / "out"), "--figures"]) == 0
    assert (tmp_path / "out/tracking.png").is_file()


@pytest.mark.parametrize(
    "how",
    [
        {"groups": False},
        {"attributes": False},
        {"as_built": True},
        {"by_origins": True},
        {"q": (0.5, -0.7)},
    ],
    ids=str,
)
def test_robot_does_not_depend_on_the_drawing_method(how: dict) -> None:
    built = build_robot(drawn(**how))
    assert built.robot is not None, built.findings
    robot, old = built.robot, "attributes" in how
    if old:  # old names contain neither muscle names nor task axes
        names = {f"motor{k}": f"cable_{k + 1}" for k in range(4)}
        robot = robot.with_muscles(replace(m, name=names[m.name]) for m in robot.muscles)
    require_same_dynamics(robot, tasks=not old)


@pytest.mark.slow
@given(
    rotation=st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    shift=st.tuples(*[st.floats(-200.0, 200.0)] * 3),
    nesting=st.integers(0, 3),
    seed=st.integers(0, 2**16),
    q=st.tuples(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6)),
)
def test_robot_does_not_depend_on_position_nesting_and_order(
    rotation, shift, nesting, seed, q
) -> None:
    """Masses, muscles and joints do not depend on the direction of gravity."""
    motion = np.eye(4)
    motion[:3, :3] = Rotation.from_rotvec(rotation).as_matrix()
    motion[:3, 3] = shift
    built = build_robot(drawn(motion=motion, nesting=nesting, seed=seed, q=q))
    assert built.robot is not None, built.findings
    require_same_dynamics(built.robot, gravity=False, tasks=False)
    initial = [c.initial for c in built.robot.coordinates]
    np.testing.assert_allclose(initial, q, atol=1e-9)


@pytest.mark.slow
@given(nesting=st.integers(0, 3), seed=st.integers(0, 2**16))
def test_nesting_and_order_do_not_change_gravity_and_tasks(nesting, seed) -> None:
    built = build_robot(drawn(nesting=nesting, seed=seed))
    assert built.robot is not None, built.findings
    require_same_dynamics(built.robot)


def test_saved_snapshot_exports_the_same_folder(tmp_path: Path) -> None:
    snapshot = drawn(nesting=2, seed=1)
    file = write_snapshot(snapshot, tmp_path / "arm.json")
    assert read_snapshot(file) == snapshot
    export_robot(snapshot, tmp_path / "a/arm")
    export_robot(read_snapshot(file), tmp_path / "b/arm")
    assert files_of(tmp_path / "a") == files_of(tmp_path / "b")
