"""Fixtures for tests of the add-in."""

from __future__ import annotations

from fake_fusion.fixtures import fusion

__all__ = ["fusion"]
