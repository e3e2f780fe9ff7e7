"""Fixtures for tests of controllers."""

from __future__ import annotations

import pytest
from support.robots.robots import planar_2r

from sim_dart import DartDynamics


@pytest.fixture(scope="session")
def arm() -> DartDynamics:
    """Return the two-link arm of the CARDSFlow paper."""
    return DartDynamics(planar_2r())
