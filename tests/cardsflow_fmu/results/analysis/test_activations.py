"""Static optimisation: activations of a recorded motion."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.command_line import CommandLine
from support.robots.robots import EXAMPLES, planar_2r

from addin_sdfusion.robot import InputError, Robot, read_robot
from cardsflow_fmu import Experiment
from cardsflow_fmu.results.analysis.redundancy.motion import read_given_motion
from cardsflow_fmu.results.analysis.redundancy.output import (
    activation_summary,
    describe_activations,
)
from cardsflow_fmu.results.analysis.redundancy.static import static_optimisation
from cardsflow_fmu.utils.opensim_table import opensim_text, read_opensim_table
from controllers.analysis.inverse_dynamics import Motion, motion_terms
from sim_dart import CoreDynamics

ARM = EXAMPLES / "hill_arm/robot"


def read_recorded_motion(robot: Robot, file: Path, noise: float) -> Motion:
    return read_given_motion(robot, file, noise).motion


def waving_motion(robot: Robot, points: int = 21, size: float = 0.2) -> Motion:
    """Return a slow sinusoidal motion of all coordinates about their initial positions."""
    t = np.linspace(0.0, 2.0, points)[:, None]
    start = np.array([c.initial for c in robot.coordinates])
    q, qd, qdd = (size * f for f in (np.sin(t) ** 2, np.sin(2 * t), 2 * np.cos(2 * t)))
    ones = np.ones(len(start))
    return Motion(t[:, 0], start + q * ones, qd * ones, qdd * ones)


def with_bounds(robot: Robot, f_max: float) -> Robot:
    sets = tuple(
        replace(one, muscles=tuple(replace(m, f_min=0.0, f_max=f_max) for m in one.muscles))
        for one in robot.cable_sets
    )
    return replace(robot, cable_sets=sets)


def test_activations_have_the_minimum_sum_of_squares() -> None:
    """Activations between their bounds are A y, from the Lagrange multipliers y."""
    robot = read_robot(ARM)
    motion = waving_motion(robot)
    terms = motion_terms(CoreDynamics(robot), motion)
    for passive in (True, False):
        found = static_optimisation(robot, motion, passive=passive)
        assert not found.infeasible.any()
        made = -np.einsum("tmn,tm->tn", terms.L, found.forces)
        np.testing.assert_allclose(made, terms.tau, atol=1e-9 * np.abs(terms.tau).max())
    for L, a, forces in zip(terms.L, found.activations, found.forces, strict=True):
        free = (a > 1e-6) & (a < 1 - 1e-6)
        A = L[free] * (forces[free] / a[free])[:, None]
        y = np.linalg.lstsq(A, a[free], rcond=None)[0]
        np.testing.assert_allclose(A @ y, a[free], atol=1e-8)


def test_ideal_cables_share_the_torque_by_their_f_max() -> None:
    """In closed form, with one cable per direction: the pulling cable carries the torque."""
    robot = with_bounds(planar_2r(), 200.0)
    motion = waving_motion(robot)
    found = static_optimisation(robot, motion)
    np.testing.assert_allclose(found.forces, 200.0 * found.activations)
    terms = motion_terms(CoreDynamics(robot), motion).with_bounds(0.0, 200.0)
    np.testing.assert_allclose(found.forces, terms.distribute().forces, atol=1e-6)


def test_weak_muscles_require_reserves_and_exit_with_1(cardsflow: CommandLine) -> None:
    robot = with_bounds(planar_2r(), 0.01)
    found = static_optimisation(robot, waving_motion(robot))
    assert found.infeasible.any()
    first = describe_activations(activation_summary(found)).splitlines()[0]
    assert first.startswith(f"WARNING: the muscles are too weak at {found.infeasible.sum()} of 21")
    terms = motion_terms(CoreDynamics(robot), waving_motion(robot))
    made = -np.einsum("tmn,tm->tn", terms.L, found.forces) + found.reserves
    np.testing.assert_allclose(made, terms.tau, atol=1e-6)


def write_motion(robot: Robot, folder: Path, *, degrees: bool, name: str = "m.mot") -> Path:
    motion = waving_motion(robot)
    q = np.rad2deg(motion.q) if degrees else motion.q
    rows = np.column_stack([motion.times + 0.5, q])
    text = opensim_text("m", ["time", *(c.name for c in robot.coordinates)], rows)
    (folder / name).write_text(text.replace("inDegrees=no", f"inDegrees={'yes' * degrees or 'no'}"))
    return folder / name


def test_command_writes_opensim_tables(tmp_path: Path, cardsflow: CommandLine) -> None:
    robot = read_robot(ARM)
    file = write_motion(robot, tmp_path, degrees=True)
    words = ("activations", ARM, "--motion", file, "--noise", 0, "-o", tmp_path / "out")
    code, out, err = cardsflow(*words)
    assert (code, err) == (0, "")
    assert out.startswith("21 points from 0.5 to 2.5 s")
    table = read_opensim_table(tmp_path / "out/activations.sto")
    assert table.names == ("time", *(m.name for m in robot.muscles))
    expected = static_optimisation(robot, read_recorded_motion(robot, file, 0.0))
    np.testing.assert_array_equal(table.rows[:, 1:], expected.activations)
    assert cardsflow(*words)[0] == 0  # its own files are replaced
    (tmp_path / "out/forces.sto").write_text("something else\n")
    assert "already exists" in cardsflow.error_line(*words)


def test_degrees_and_states_are_converted_to_radians(tmp_path: Path) -> None:
    robot = planar_2r()
    plain = read_recorded_motion(robot, write_motion(robot, tmp_path, degrees=False), 0.0)
    turned = read_recorded_motion(
        robot, write_motion(robot, tmp_path, degrees=True, name="d.sto"), 0.0
    )
    np.testing.assert_allclose(turned.q, plain.q, atol=1e-12)
    names = [
        f"/jointset/j/{c.name}/{kind}" for kind in ("value", "speed") for c in robot.coordinates
    ]
    motion = waving_motion(robot)
    rows = np.column_stack([motion.times, motion.q, motion.qd])
    (tmp_path / "s.sto").write_text(opensim_text("states", ["time", *names], rows))
    states = read_recorded_motion(robot, tmp_path / "s.sto", 0.0)
    np.testing.assert_array_equal(states.qd, motion.qd)
    np.testing.assert_allclose(states.qdd[2:-2], motion.qdd[2:-2], atol=2e-3)


def test_experiment_tracks_an_opensim_table(tmp_path: Path) -> None:
    file = write_motion(planar_2r(), tmp_path, degrees=True)
    settings = {"reference": {"file": str(file)}, "run.duration": 0.1}
    made = Experiment.load(EXAMPLES / "planar_2r", settings)
    assert made.start.q == pytest.approx(waving_motion(planar_2r()).q[0], abs=1e-3)


WRONG = {
    "no header": ("time\ta\n0\t1\n", "the line `endheader` before the columns is missing"),
    "degrees": ("inDegrees=maybe\nendheader\ntime\ta\n", "inDegrees must be yes or no"),
    "columns": ("endheader\ntime\tjoint_1\tjoint_2\n0 1\n", "line 2 has 3 names"),
    "text": ("endheader\ntime\tjoint_1\tjoint_2\n0 1 b\n", "is not a valid OpenSim table"),
    "coordinates": ("endheader\ntime\tx\n0 1\n1 2\n2 3\n", "no column q.joint_1"),
}


@pytest.mark.parametrize("case", WRONG)
def test_invalid_motion_is_reported_in_one_line(
    case: str, tmp_path: Path, cardsflow: CommandLine
) -> None:
    text, message = WRONG[case]
    (tmp_path / "m.mot").write_text(text)
    robot = EXAMPLES / "planar_2r/robot"
    line = cardsflow.error_line("activations", robot, "--motion", tmp_path / "m.mot")
    assert message in line
    assert not (tmp_path / "activations").exists()


def test_muscle_without_activation_is_named() -> None:
    robot = read_robot(EXAMPLES / "pneumatic_elbow/robot")
    with pytest.raises(InputError, match="'mckibben' has no activation"):
        static_optimisation(robot, waving_motion(robot))
    with pytest.raises(InputError, match="has no f_max; set it"):
        static_optimisation(with_bounds(planar_2r(), math.inf), waving_motion(planar_2r()))


OPENSIM = {
    "bifemlh_r": (0.15356018, 0.15419982),
    "bifemsh_r": (0.02915427, 0.02140444),
    "glut_max2_r": (0.06631305, 0.08146352),
    "psoas_r": (0.01, 0.01),
    "rect_fem_r": (0.01, 0.01),
    "vas_int_r": (0.01, 0.01),
    "med_gas_r": (0.01, 0.01),
    "soleus_r": (0.01, 0.01),
    "tib_ant_r": (0.0527692, 0.05187973),
}
"""Results of StaticOptimization of OpenSim 4.6 at 0.3 and 0.5 s."""


def test_activations_match_opensim_static_optimization(shared: Path, tmp_path: Path) -> None:
    """With Thelen muscles; the tolerance of the optimiser of OpenSim is about 1e-5."""
    robot = read_robot(shared / "models/opensim/leg6dof9musc.osim")
    t = np.linspace(0.0, 1.0, 51)
    s = t**3 * (10 - 15 * t + 6 * t * t)
    columns = [t]
    for k, c in enumerate(robot.coordinates):
        low, high = max(c.lower, -2.0) + 1e-3, min(c.upper, 2.0) - 1e-3
        way = (0.15 if c.unit == "rad" else 0.02) * (-1.0) ** k
        q = c.initial + (np.clip(c.initial + way, low, high) - c.initial) * s
        columns.append(np.rad2deg(q) if c.unit == "rad" else q)
    names = ["time", *(c.name for c in robot.coordinates)]
    text = opensim_text("m", names, np.column_stack(columns))
    (tmp_path / "m.mot").write_text(text.replace("inDegrees=no", "inDegrees=yes"))
    found = static_optimisation(robot, read_recorded_motion(robot, tmp_path / "m.mot", 0.0))
    assert found.undriven == ("pelvis_tilt", "pelvis_tx", "pelvis_ty")
    expected = np.array([OPENSIM[name] for name in found.muscle_names]).T
    np.testing.assert_allclose(found.activations[[15, 25]], expected, atol=2e-5)
