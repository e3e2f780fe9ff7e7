"""Steady tracking error of model predictive control."""

from __future__ import annotations

import pytest
from support.controllers.predicted_mass import PERIOD, Law

from controllers.qp import law_in_c


def test_constant_jerk_is_followed_without_steady_error() -> None:
    """With the exact rate at the begin of a tick T, it is d j T^2 / (12 k) = 7e-6.

    The law is e'' + d e' + k e = 0, and the force is constant in a tick.
    """
    law = Law(lambda: 0.0, 0.0)
    law["forces_cost"][:] = 1e-12
    law.jerk = 4.0
    q, qd, p, v, a = 0.0, 0.0, 0.0, 0.0, -3.0
    for _ in range(150):
        law.reference[:] = p, v, a
        status, force = law.tick(q, qd)
        assert status == law_in_c.SOLVED
        q, qd = q + PERIOD * (qd + PERIOD * force / 2), qd + PERIOD * force
        p += PERIOD * (v + PERIOD * (a / 2 + law.jerk * PERIOD / 6))
        v, a = v + PERIOD * (a + law.jerk * PERIOD / 2), a + law.jerk * PERIOD
    assert q == pytest.approx(p, abs=1e-8)
    assert qd == pytest.approx(v - law.jerk * PERIOD**2 / 12, abs=1e-8)
