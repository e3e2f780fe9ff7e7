"""Masters of experiments, and the requirements of a run in C only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from cardsflow_fmu.cosim.external_fmu import without_missing_loads
from cardsflow_fmu.cosim.master import Master
from cardsflow_fmu.cosim.participant import Participant
from cardsflow_fmu.cosim.signals.ports import external_load_signals
from cardsflow_fmu.experiment.experiment import Experiment

from .by_role import C_MODELS, missing_in_c
from .direct_participant import DirectParticipant


def experiment_master(experiment: Experiment, participants: Mapping[str, Participant]) -> Master:
    """Return the master of a run, which connects the participants with the given roles."""
    settings = experiment.run
    return Master(
        [participants[name] for name in experiment.columns],
        without_missing_loads(
            experiment.wiring,
            experiment.fmus,
            participants.values(),
            external_load_signals(experiment.robot, experiment.plant.wrenches),
        ),
        step=settings.step,
        steps=settings.steps,
        coupling=experiment.stepping,
        every={"controller": round(experiment.controller.period / settings.step)},
    )


def native_loop(experiment: Experiment) -> Master:
    """Return the master of a run in C only; `missing_in_loop` must be None.

    A step does not execute Python code and releases the Python lock (GIL), so that loops can run in
    parallel threads.
    """
    names = reversed(experiment.columns)
    models = {name: DirectParticipant(name, C_MODELS[name](experiment)) for name in names}
    return experiment_master(experiment, models)


def missing_in_loop(experiment: Experiment, names: Sequence[str] | None = None) -> str | None:
    """Return a feature of a run that C does not support, or None."""
    names = experiment.columns if names is None else names
    feature = _unsupported_part(experiment, names)
    requirements = (missing_in_c(experiment, name) for name in names)
    return feature or next((text for text in requirements if text is not None), None)


def _unsupported_part(experiment: Experiment, names: Sequence[str]) -> str | None:
    """Return a part of the run, except models, that C does not support, or None."""
    if experiment.hardware.use:
        return "hardware"
    external = [name for name in names if name in experiment.fmus]
    if external:
        return f"external FMUs ({', '.join(external)})"
    engines = {"plant": experiment.plant.engine, "controller": experiment.controller.engine}
    in_dart = [name for name, engine in engines.items() if engine == "dart"]
    named = ", ".join(f"{role}.engine" for role in in_dart)
    return f'the engine "dart" ({named})' if in_dart else None
