"""Native loop: plant, controller and reference in C, with many steps per call.

All participants are models of native FMUs. A step does not execute Python code and releases the
Python lock (GIL), so that loops can run in parallel threads.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

from addin_sdfusion.robot import InputError
from cardsflow_fmu.cosim.master import Master
from cardsflow_fmu.cosim.pacing import Pacer
from cardsflow_fmu.cosim.recording import Progress, Recording, RowSink, Watch
from cardsflow_fmu.experiment.experiment import Experiment

from .by_role import C_MODELS, missing_in_c, require_in_c
from .direct_participant import DirectParticipant

_ADVICE = "run it with `compute = 'python'`, or as FMUs"


def missing_in_loop(experiment: Experiment, names: Sequence[str] | None = None) -> str | None:
    """Return a feature of a run that C does not support, or None."""
    names = experiment.columns if names is None else names
    feature = _unsupported_part(experiment, names)
    requirements = (missing_in_c(experiment, name) for name in names)
    return feature or next((text for text in requirements if text is not None), None)


def require_native(experiment: Experiment, names: Sequence[str]) -> None:
    """Raise an error if an experiment requires Python or DART.

    Raises:
        InputError: The experiment requires Python or DART. The message names the requirement.
    """
    unsupported = _unsupported_part(experiment, names)
    if unsupported is not None:
        raise InputError(
            f"a native loop does not support {unsupported}; {_ADVICE}", file=experiment.file
        )
    for name in names:
        require_in_c(experiment, name, _ADVICE)


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


class NativeLoop(Master):
    """Run of an experiment that computes only in C.

    Raises:
        InputError: The experiment requires Python or DART. The message names the requirement.
    """

    def __init__(self, experiment: Experiment) -> None:
        require_native(experiment, experiment.columns)
        self._is_ready = True
        self.models = [C_MODELS[name](experiment) for name in experiment.columns]
        named = zip(experiment.columns, self.models, strict=True)
        parts = [DirectParticipant(name, model) for name, model in reversed(list(named))]
        run, period = experiment.run, experiment.controller.period
        super().__init__(
            parts[::-1],
            experiment.wiring,
            step=run.step,
            steps=run.steps,
            coupling=experiment.stepping,
            every={"controller": round(period / run.step)},
        )

    def run(
        self,
        progress: Progress | None = None,
        pacer: Pacer | None = None,
        watch: Watch | None = None,
        sink: RowSink | None = None,
    ) -> Recording:
        """Run once; see `Master.run`.

        Raises:
            InputError: The loop has run, or is closed.
        """
        if not self._is_ready:
            raise InputError(
                "a native loop can run only once and not after it is closed; create a new one"
            )
        self._is_ready = False
        return super().run(progress, pacer, watch, sink)

    def close(self) -> None:
        """Reject further runs."""
        self._is_ready = False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
