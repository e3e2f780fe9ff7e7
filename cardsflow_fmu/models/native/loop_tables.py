"""Tables of a loop in a browser: order of the models, and copied signals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cardsflow_fmu.cosim.coupling import Coupling
from cardsflow_fmu.cosim.participant import Copy, WiredPorts
from cardsflow_fmu.cosim.wiring import Wiring, connect
from cardsflow_fmu.utils.arrays import FloatArray


class LoopTables(NamedTuple):
    """Tables of `native_loop_plan`; see `runtime/csrc/loop/native_loop.h`.

    Attributes:
        turns: Shape (t, 4).
        copies: Shape (c, 4).
        changes: Shape (c, 2).
    """

    turns: NDArray[np.int32]
    copies: NDArray[np.int32]
    changes: FloatArray


def loop_tables(
    models: Sequence[WiredPorts], wiring: Wiring, stepping: Coupling, every: Mapping[str, int]
) -> LoopTables:
    """Return the tables of a loop.

    Args:
        wiring: Connections that differ from those by equal names; constant inputs are set here.
        every: Number of base steps per step of each model, by name.
    """
    numbers = {model.name: k for k, model in enumerate(models)}
    copies = connect(models, wiring)
    groups, _ = stepping.stages(list(numbers))
    turns, routes, changes = [], [], []
    for stage, group in enumerate(groups):
        for name in group:
            turns.append((numbers[name], every[name], len(copies[name]), stage))
            routes += [_route(copy, name, models) for copy in copies[name]]
            changes += [(copy.change.factor, copy.change.offset) for copy in copies[name]]
    return LoopTables(
        _table(turns, 4),
        _table(routes, 4),
        np.array(changes, dtype=np.float64).reshape(-1, 2),
    )


def _table(rows: Sequence[tuple[int, ...]], width: int) -> NDArray[np.int32]:
    return np.array(rows, dtype=np.int32).reshape(-1, width)


def _route(copy: Copy, target: str, models: Sequence[WiredPorts]) -> tuple[int, int, int, int]:
    """Return source model, index, target model and index of a copy."""
    source = next(k for k, model in enumerate(models) if model.outputs is copy.source)
    end = next(k for k, model in enumerate(models) if model.name == target)
    return source, len(models[source].input_names) + copy.source_index, end, copy.target_index
