"""Fixtures of the add-in's tests."""

from __future__ import annotations

from fake_fusion.fixtures import fusion

__all__ = ["fusion"]
