"""Costs of motions of a mass on a line, against closed forms; custom costs and their errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.command_line import CommandLine
from support.robots.robots import EXAMPLES
from support.robots.slider import MASS, responses, slide, slider_file

from cardsflow_fmu.simulation.optimal.optimise import load_for_motion, optimise

CUSTOM = """
import numpy as np
from controllers import MotionCost

class Far(MotionCost):
    def final(self, state):
        return float(-state.q[0] - 0.5 * state.qd[0])

class Curved(MotionCost):
    def running(self, state):
        return 3.0 * (state.q[0] - 1.0) ** 2 + 2.0 * state.q[0] * state.qd[0]

    def running_gradient(self, state):
        q, qd = state.q, state.qd
        return 6.0 * (q - 1.0) + 2.0 * qd, 2.0 * q

class Wrong(Curved):
    def running_gradient(self, state):
        return 5.0 * state.q, 0.0 * state.qd

class Shape(Curved):
    def running_gradient(self, state):
        return np.zeros(3), np.zeros(1)

class Infinite(MotionCost):
    def final(self, state):
        return float("nan")

class Broken(MotionCost):
    def final(self, state):
        return state.q["x"]

class Empty(MotionCost):
    pass
"""


def test_least_accelerations_are_those_of_the_cubic(tmp_path: Path) -> None:
    """Int a² dt = 12 d² / T³ / (1 - 1/N²) with constant accelerations, which fall linearly."""
    motion = slide(tmp_path, {"motion.cost": {"accelerations": 2.0}})
    assert motion.solution.cost == pytest.approx(24.0 / 0.8**3 / (1 - 1 / 20**2), rel=1e-6)
    u = motion.solution.iterate.u[:, 0]
    np.testing.assert_allclose(np.diff(u), np.diff(u).mean(), rtol=1e-4)


def test_accelerations_determine_a_free_duration(tmp_path: Path) -> None:
    cost = {"accelerations": 2.0, "time": 30.0}
    motion = slide(tmp_path, {"motion.cost": cost, "motion.duration": [0.2, 4.0]})
    effort = 24.0 / (1 - 1 / 20**2)
    assert motion.duration == pytest.approx((3.0 * effort / 30.0) ** 0.25, rel=1e-4)


def test_goal_with_a_weight_balances_effort_and_deviation(tmp_path: Path) -> None:
    """Minimum of w (x - 1)² + h u'u with v = 0 at the end."""
    motion = slide(tmp_path, {"motion.goals": [{"q": 1.0, "weight": 40.0}]})
    rows = responses(20, 0.8, [20])[:, :-1]
    effort = np.linalg.inv(rows @ rows.T)[0, 0] * 0.8 / 20  # of x = 1, v = 0
    assert motion.solution.iterate.x[-1] == pytest.approx([40.0 / (40.0 + effort), 0.0], abs=1e-5)
    task = {"motion.goals": [{"y": [0.5, -0.1], "weight": 1e7}], "motion.duration": 0.8}
    arm = optimise(load_for_motion(EXAMPLES / "hill_arm", {**task, "motion.intervals": 20}))
    y = [arm.columns[name][-1] for name in arm.columns if name.startswith("y.")]
    np.testing.assert_allclose(y, [0.5, -0.1], atol=1e-3)


def test_tracking_follows_a_recorded_motion(tmp_path: Path) -> None:
    """With a much larger weight than the effort; the record is x = t²."""
    t = np.linspace(0.0, 1.0, 101)
    rows = "\n".join(f"{a!r},{b!r}" for a, b in zip(t.tolist(), (t * t).tolist(), strict=True))
    (tmp_path / "record.csv").write_text("time,q.x\n" + rows + "\n")
    cost = {"tracking": {"file": str(tmp_path / "record.csv"), "q": 1e6}, "forces": 1e-3}
    motion = slide(tmp_path, {"motion.cost": cost, "motion.goals": []})
    x = motion.solution.iterate.x
    np.testing.assert_allclose(x[:, 0], np.linspace(0.0, 0.8, 21) ** 2, atol=1e-3)
    assert motion.solution.iterate.u[3:-3].mean() == pytest.approx(2.0 * MASS, rel=0.01)


@pytest.mark.parametrize("name", ["Far", "Curved"])
def test_custom_cost_equals_the_closed_form(tmp_path: Path, name: str) -> None:
    """Both are quadratic in the forces: the optimum solves the normal equations."""
    (tmp_path / "cost.py").write_text(CUSTOM)
    goal = {"motion.goals": [{"rest": False, "q": 1.0, "weight": 1e-9}]}
    cost = {"forces": 1.0, "function": f"cost.py:{name}"}
    motion = slide(tmp_path, {**goal, "motion.cost": cost})
    N, h = 20, 0.8 / 20
    nodes = responses(N, 0.8, list(range(N + 1)))[:, :-1]
    q, v = nodes[: N + 1], nodes[N + 1 :]
    if name == "Far":
        u = (q[-1] + 0.5 * v[-1]) / (2.0 * h)
    else:  # int 2 x v dt by the trapezoidal rule
        w = h * np.r_[0.5, np.ones(N - 1), 0.5][:, None]
        H = 2.0 * h * np.eye(N) + 6.0 * q.T @ (w * q) + 2.0 * (q.T @ (w * v) + v.T @ (w * q))
        u = np.linalg.solve(H, 6.0 * (w * q).sum(axis=0))
    np.testing.assert_allclose(motion.solution.iterate.u[:, 0], u, rtol=1e-3, atol=1e-3)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("cost.py:Wrong", "Wrong.running_gradient returns "),
        ("cost.py:Shape", "Shape.running_gradient must return two finite arrays of shape (1,)"),
        ("cost.py:Infinite", "Infinite.final returned nan; it must be finite"),
        ("cost.py:Broken", "cost.py:31: IndexError: only integers"),
        ("cost.py:Empty", "Empty defines neither running nor final"),
        ("cost.py:Missing", "no class 'Missing'"),
        ("no_cost.py:Mine", "no_cost.py: motion.cost.function: does not exist"),
    ],
)
def test_invalid_custom_cost_is_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, message: str
) -> None:
    (tmp_path / "cost.py").write_text(CUSTOM)
    own = ["--set", f'motion.cost.function="{name}"']
    line = CommandLine(capsys).error_line("optimise", slider_file(tmp_path), "-q", *own)
    assert message in line
    assert "cost.py" in line
