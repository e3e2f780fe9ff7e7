"""Steps of plants."""

from __future__ import annotations

from typing import Any

from sim_dart import Plant


def steps(plant: Plant, count: int, *inputs: Any, **more: Any) -> None:
    """Step a plant with constant inputs, those of `Plant.step`."""
    for _ in range(count):
        plant.step(*inputs, **more)
