"""Gradients of PyTorch through steps of a batch equal differences."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import read_robot
from sim_dart import Batch

torch = pytest.importorskip("torch")


def test_gradients_through_steps_equal_differences() -> None:
    from cardsflow_fmu.gym.torch_step import BatchStep

    batch = Batch(read_robot(EXAMPLES / "hill_arm" / "robot"), 2, 0.01, substeps=3)
    for _ in range(5):  # away from the smallest activations, where differences are one-sided
        batch.step(np.full(6, 0.4))
    step = BatchStep(batch)
    state = step.start().requires_grad_(True)
    commands = torch.full((2, 6), 0.3, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(
        lambda x, u: step(step(x, u), u), (state, commands), eps=1e-6, atol=1e-5, rtol=1e-4
    )


def test_gradients_of_points_equal_differences() -> None:
    from cardsflow_fmu.gym.torch_step import BatchStep

    batch = Batch(read_robot(EXAMPLES / "planar_2r" / "robot"), 2, 0.01)
    step = BatchStep(batch)
    state, commands = step.start().requires_grad_(True), torch.full((2, 4), 20.0)
    commands = commands.double() + torch.arange(4)
    assert torch.autograd.gradcheck(lambda x: step.position(step(x, commands)), state, eps=1e-6)
