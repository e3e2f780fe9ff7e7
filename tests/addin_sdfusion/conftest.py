"""What tests of the add-in share."""

from __future__ import annotations

from fake_fusion.fixtures import fusion

__all__ = ["fusion"]
