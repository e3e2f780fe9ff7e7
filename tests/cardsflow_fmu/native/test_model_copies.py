"""Copies and pickled models continue as the original does, bit by bit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.robots.plants import copies
from support.robots.robots import EXAMPLES

from cardsflow_fmu import Experiment
from cardsflow_fmu.models.by_role import C_MODELS, model_class

_QUADPROG = {"controller.solver": "quadprog"}
_CASES: list[tuple[str, str, dict[str, Any]]] = [
    *[("no_joint_encoders", role, {}) for role in C_MODELS],
    ("hill_arm", "plant", {}),
    ("hill_arm", "controller", {}),
    ("planar_2r", "controller", _QUADPROG),
    ("planar_2r", "plant", {"plant.engine": "dart"}),
]


@pytest.mark.parametrize(("example", "role", "settings"), _CASES)
def test_copied_model_continues_as_the_original(
    example: str, role: str, settings: dict[str, Any]
) -> None:
    model = model_class(role)(Experiment.load(EXAMPLES / example, settings))
    model.parameters[:1] *= 1.01
    model.initialize()
    h = 0.01
    for k in range(5):
        model.step(k * h, h)
    before = model.values.copy()
    report = model.indices("report") if role == "controller" else []
    same = np.setdiff1d(np.arange(before.size), report)  # without computing times
    twins = copies(model)
    for twin in twins:
        np.testing.assert_array_equal(twin.values, before)
        for k in range(5, 8):
            twin.step(k * h, h)
    np.testing.assert_array_equal(model.values, before)
    for k in range(5, 8):
        model.step(k * h, h)
    for twin in twins:
        np.testing.assert_array_equal(twin.values[same], model.values[same])
        assert twin.get_state() == model.get_state()
