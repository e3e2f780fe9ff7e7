"""A closed loop over FMUs as they are built, without what `simulate` does around it."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np

from cardsflow_fmu import Experiment
from cardsflow_fmu.cosim.external_fmu import fitting_wiring
from cardsflow_fmu.cosim.fmu_instance import FmuInstance
from cardsflow_fmu.cosim.master import Master
from cardsflow_fmu.cosim.recording import Recording
from cardsflow_fmu.cosim.signals.ports import load_signals
from cardsflow_fmu.experiment.settings.run import Compute
from cardsflow_fmu.simulation.build import build


def co_simulate(experiment: Experiment, folder: Path, *, compute: Compute) -> Recording:
    """A run over the FMUs that are built."""
    fmus = build(experiment, folder, compute=compute)
    fmus.pop("hardware", None)  # there is none
    parts = {name: FmuInstance(name, file, folder / name) for name, file in fmus.items()}
    loads = load_signals(experiment.robot)
    master = Master(
        [parts[name] for name in ("plant", "reference", "controller")],
        fitting_wiring(experiment.wiring, experiment.fmus, parts.values(), loads),
        step=experiment.run.step,
        steps=experiment.run.steps,
        coupling=experiment.run.stepping,
        every={"controller": round(experiment.controller.period / experiment.run.step)},
    )
    recording = master.run()
    for part in parts.values():
        part.close()
    return recording


FORCES = ("f", "slack")
LAWS = ("f", "u", "slack", "tension")
"""Columns with commands and tensions of muscles with laws."""


def assert_rows_agree(
    found: Any, expected: Any, *, forces: float, others: float, of: Collection[str] = FORCES
) -> None:
    """The same columns, near each other relative to the largest number of a column, or to 1.

    Columns of forces, whose names begin with `of`, have a tolerance of their own.
    """
    assert found.names == expected.names
    for k, name in enumerate(expected.names):
        scale = max(np.abs(expected.rows[:, k]).max(), 1.0)
        near = forces if name.split(".")[0] in of else others
        np.testing.assert_allclose(
            found.rows[:, k], expected.rows[:, k], rtol=0, atol=near * scale, err_msg=name
        )


def assert_native_agrees(
    experiment: Experiment, folder: Path, *, python_of: Experiment | None = None, **tolerances: Any
) -> Recording:
    """Native FMUs give the rows of those with Python models; returns the former.

    Args:
        experiment: The experiment.
        folder: For the FMUs.
        python_of: That of the Python models, if it is another one.
        tolerances: Of `assert_rows_agree`.
    """
    python = co_simulate(python_of or experiment, folder / "python", compute="python")
    native = co_simulate(experiment, folder / "native", compute="c")
    assert native.failure is None
    assert_rows_agree(native, python, **tolerances)
    return native
