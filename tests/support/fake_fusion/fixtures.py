"""Fixtures for tests of the add-in, imported by a conftest."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from .control import Fake
from .install import install


@pytest.fixture
def fusion() -> Iterator[Fake]:
    """Start a new Fusion without documents; `import adsk.core` works in the test."""
    with install() as fake:
        yield fake
