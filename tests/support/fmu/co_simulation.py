"""A closed loop over FMUs as they are built, without what `simulate` does around it."""

from __future__ import annotations

from pathlib import Path

from cardsflow_fmu import Experiment
from cardsflow_fmu.cosim.external_fmu import fitting_wiring
from cardsflow_fmu.cosim.fmu_instance import FmuInstance
from cardsflow_fmu.cosim.master import Master
from cardsflow_fmu.cosim.recording import Recording
from cardsflow_fmu.signals.ports import load_signals
from cardsflow_fmu.simulation.build import build


def co_simulate(experiment: Experiment, folder: Path, *, native: bool) -> Recording:
    """A run over the FMUs that are built."""
    fmus = build(experiment, folder, native=native)
    fmus.pop("hardware", None)  # there is none
    parts = {name: FmuInstance(name, file, folder / name) for name, file in fmus.items()}
    loads = load_signals(experiment.robot)
    master = Master(
        [parts[name] for name in ("plant", "reference", "controller")],
        fitting_wiring(experiment.wiring, experiment.fmus, parts.values(), loads),
        step=experiment.run.step,
        steps=experiment.run.steps,
        coupling=experiment.run.coupling,
        every={"controller": round(experiment.controller.period / experiment.run.step)},
    )
    recording = master.run()
    for part in parts.values():
        part.close()
    return recording
