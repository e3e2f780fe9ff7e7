"""Fixtures with the add-in running in a new fake Fusion."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from support.designs.exported import addin_sdfusion, running
from support.designs.user import User, build_arm


@pytest.fixture
def addin(fusion: Any) -> Iterator[Any]:
    """Start the add-in before the test and stop it afterwards."""
    with running():
        yield addin_sdfusion


@pytest.fixture
def user(fusion: Any, addin: Any) -> User:
    """Return a simulated user in a design with a torso and an arm."""
    build_arm()
    return User(fusion)
