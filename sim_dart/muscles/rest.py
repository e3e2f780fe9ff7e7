"""The commands with which muscles at rest hold wanted tensions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sim_dart.core.arrays import FloatArray

if TYPE_CHECKING:
    from .laws import MuscleLaws


_HALVINGS = 60


def resting_commands(laws: MuscleLaws, tensions: FloatArray) -> FloatArray:
    """The commands with which muscles that stand still at the last q hold these tensions.

    Where no command does, the nearest is taken; of a passive muscle, 0. The muscles' states change.

    Args:
        laws: The muscles.
        tensions: Shape (m,), in [N].

    Returns:
        Shape (m,), each in the unit of its law.
    """
    least = laws.command_low
    most = np.where(np.isfinite(laws.command_high), laws.command_high, np.maximum(tensions, least))
    grows = _held(laws, least) <= _held(laws, most)
    weak, strong = np.where(grows, least, most), np.where(grows, most, least)
    if_weak = _held(laws, weak) >= tensions
    strong = np.where(if_weak, weak, strong)
    for _ in range(_HALVINGS):
        middle = 0.5 * (weak + strong)
        enough = _held(laws, middle) >= tensions
        weak, strong = np.where(enough, weak, middle), np.where(enough, middle, strong)
    return strong


def resting_reach(laws: MuscleLaws) -> tuple[FloatArray, FloatArray]:
    """The tensions that muscles hold at rest with their smallest and largest commands.

    The smaller of the two first, each of shape (m,), in [N]; infinite for ideal cables. The
    muscles' states change.

    Args:
        laws: The muscles.
    """
    bounded = np.isfinite(laws.command_high)
    least = _held(laws, laws.command_low)
    most = _held(laws, np.where(bounded, laws.command_high, 0.0))
    most = np.where(bounded, most, np.inf)
    return np.minimum(least, most), np.maximum(least, most)


def _held(laws: MuscleLaws, commands: FloatArray) -> FloatArray:
    """The tensions of muscles that have stood still with these commands for long."""
    laws.start(commands)
    laws.drive(np.zeros(laws.torques.size), commands)
    return laws.tensions.copy()
