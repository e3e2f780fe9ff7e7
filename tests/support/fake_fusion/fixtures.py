"""Fixtures for tests of the add-in; a conftest imports them."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from .control import Fake
from .install import install


@pytest.fixture
def fusion() -> Iterator[Fake]:
    """A newly started Fusion without documents; `import adsk.core` works within the test."""
    with install() as fake:
        yield fake
