"""The add-in, running in a new Fusion."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from support.designs.exported import addin_sdfusion, running
from support.designs.user import User, build_arm


@pytest.fixture
def addin(fusion: Any) -> Iterator[Any]:
    """The add-in, started before and stopped after the test."""
    with running():
        yield addin_sdfusion


@pytest.fixture
def user(fusion: Any, addin: Any) -> User:
    """Someone who clicks, in a torso with an arm."""
    build_arm()
    return User(fusion)
