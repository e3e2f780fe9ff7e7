"""Lost forces without tension sensors: a joint with three cables, and Roboy's arm."""

from __future__ import annotations

import numpy as np
import pytest
from support.controllers.fault_monitor import KINDS, NOISE, STEP, FaultMonitor

MASS, BEGIN, END = 0.05, 130, 230
L = np.array([0.03, 0.03, -0.02])


def run(
    losses: np.ndarray,
    load: float = 0.0,
    rise: int = 1,
    rate: float = 0.1,
    end: int = END,
    stiffness: float = 0.0,
    estimate_error: float = 0.0,
) -> FaultMonitor:
    """Move a joint by known forces; from BEGIN on, shares of them are lost, and a load acts.

    The load rises for some ticks. With a stiffness, muscle 2 jams. The encoder is accurate; cables
    have no length sensors. The model is exact; `estimate_error` is the largest error of the
    estimate of q.
    """
    monitor, random = FaultMonitor(1, 3, rate), np.random.default_rng(2)
    monitor.write(length_noise=np.inf, load_noise=0.05, load_change=3.0)
    q, qd = 0.0, 0.0
    for tick in range(end):
        forces = np.array([60.0, 60.0, 175.0]) + 40.0 * np.sin(0.11 * tick * np.array([1, 1, 1.7]))
        acceleration = -float(L @ forces) / MASS
        known = tick >= BEGIN
        if tick <= BEGIN:
            jammed = forces[2] - stiffness * L[2] * q
        lost = known * float(L @ (losses * forces))
        if known and stiffness:
            lost = float(L[2] * (forces[2] - jammed - stiffness * L[2] * q))
        actual = acceleration + (lost - known * load * min((tick - BEGIN + 1) / rise, 1.0)) / MASS
        if tick:
            q, qd = q + STEP * (qd + STEP * actual), qd + STEP * actual
        measured = q + random.normal(0.0, NOISE)
        estimate = measured + estimate_error * np.sin(2.3 * tick)
        monitor.write(
            lengths=np.nan, encoders=measured, tensions=np.nan, commands=forces, q=estimate
        )
        monitor.write(path_lengths=0.3 + L * estimate, jacobian=L)
        assert monitor.fit_pose()
        monitor.tick()
        monitor.write(acceleration=acceleration, mobility=1.0 / MASS, acting=forces, velocity=qd)
        if monitor.move(1 if tick else 0):
            break
    return monitor


@pytest.mark.parametrize(("lost", "kind"), [(0.5, "weak"), (1.0, "broken")])
def test_lost_force_is_found_by_its_direction_and_course(lost: float, kind: str) -> None:
    monitor = run(np.array([0.0, 0.0, lost]))
    assert monitor.found == {kind: 2}
    assert monitor.array("value")[2] == pytest.approx(1.0 - lost, abs=0.05)
    assert monitor.array("begin")[2] == pytest.approx(BEGIN * STEP, abs=3 * STEP)
    assert monitor.array("confidence")[2] >= 0.99


def test_jammed_muscle_is_found_whatever_the_estimate_is() -> None:
    """With constant moment arms, the fit and all evidence do not depend on the estimate of q."""
    monitors = [run(np.zeros(3), stiffness=5e3, estimate_error=e) for e in (0.0, 2.9 * NOISE)]
    for monitor in monitors:
        assert monitor.found == {"jammed": 2}
    for name in ("statistic", "value", "begin", "confidence"):
        assert monitors[1].array(name)[2] == pytest.approx(monitors[0].array(name)[2], rel=1e-9)


def test_two_equal_muscles_are_both_reported_and_limited() -> None:
    monitor = run(np.array([1.0, 0.0, 0.0]))
    kinds = [KINDS[int(kind)] for kind in monitor.array("kind")[:3]]
    assert kinds == ["broken", "broken", "none"]
    assert monitor.array("confidence")[:2] == pytest.approx([0.5, 0.5], abs=0.01)
    assert monitor.array("other")[:2].tolist() == [1.0, 0.0]
    assert monitor.array("bound").tolist() == [0.0, 0.0, 500.0]


@pytest.mark.parametrize("load", [-2.0, 0.3, 5.0])
def test_unknown_load_is_not_a_lost_force(load: float) -> None:
    assert run(np.zeros(3), load).found == {}


@pytest.mark.parametrize(("rise", "load"), [(4, 3.0), (16, -3.0), (20, -3.0)])
def test_load_that_rises_is_not_a_lost_force(rise: int, load: float) -> None:
    """A weak or a jammed muscle fits such a load better than a constant load does."""
    assert run(np.zeros(3), load, rise, rate=1000.0).found == {}
