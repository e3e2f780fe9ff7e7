"""Steps of a batch as functions of PyTorch, with exact gradients."""

from __future__ import annotations

from typing import Any

import numpy as np

from addin_sdfusion.robot import InputError
from sim_dart import Batch

try:
    import torch
except ImportError as error:
    raise InputError("gradients need the package torch; install it") from error


class _Step(torch.autograd.Function):  # type: ignore[misc]
    @staticmethod
    def forward(context: Any, state: Any, commands: Any, batch: Batch) -> Any:
        batch.set_state(state.detach().double().numpy())
        u = commands.detach().double().numpy()
        if state.requires_grad or commands.requires_grad:
            A, B = batch.derivatives(u)
            m = u.shape[1]
            context.save_for_backward(torch.from_numpy(A), torch.from_numpy(B[:, :, :m].copy()))
        batch.step(u)
        return torch.from_numpy(np.ascontiguousarray(batch.get_state())).to(state.dtype)

    @staticmethod
    def backward(context: Any, gradient: Any) -> Any:
        A, B = context.saved_tensors
        row = gradient.double().unsqueeze(1)
        return (row @ A).squeeze(1), (row @ B).squeeze(1), None


class _Position(torch.autograd.Function):  # type: ignore[misc]
    @staticmethod
    def forward(context: Any, state: Any, batch: Batch) -> Any:
        context.save_for_backward(torch.from_numpy(batch.task_jacobian().copy()))
        context.rest = state.shape[1] - batch.q.shape[1]
        return torch.from_numpy(batch.task_position).to(state.dtype)

    @staticmethod
    def backward(context: Any, gradient: Any) -> Any:
        (J,) = context.saved_tensors
        by_q = (gradient.double().unsqueeze(1) @ J).squeeze(1)
        return torch.nn.functional.pad(by_q, (0, context.rest)), None


class BatchStep:
    """Differentiable step of all instances of a batch.

    Args:
        batch: The batch. Its state is that of the last step.
    """

    def __init__(self, batch: Batch) -> None:
        self.batch = batch

    def start(self, dtype: Any = torch.float64) -> Any:
        """Return the current states (q, qd, states of muscles), a tensor of shape (n, nx)."""
        return torch.from_numpy(self.batch.get_state()).to(dtype)

    def __call__(self, state: Any, commands: Any) -> Any:
        """Return the states after a step, a tensor of shape (n, nx).

        Args:
            state: States, shape (n, nx).
            commands: Commands of the muscles, shape (n, m).
        """
        return _Step.apply(state, commands, self.batch)

    def position(self, state: Any) -> Any:
        """Return the task coordinates y, a tensor of shape (n, k).

        Args:
            state: The current states, from `start` or the last step.
        """
        return _Position.apply(state, self.batch)
