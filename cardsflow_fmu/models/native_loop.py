"""Native loop: plant, controller and reference in C, with many steps per call.

All participants are models of native FMUs. A step does not execute Python code. Calls release the
Python lock (GIL), so that loops can run in parallel threads.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Self

import numpy as np

from addin_sdfusion.robot import CardsflowError, InputError, SimulationError
from cardsflow_fmu.cosim.master import columns_of
from cardsflow_fmu.cosim.pacing import Pacer
from cardsflow_fmu.cosim.participant import WiredPorts
from cardsflow_fmu.cosim.recording import Recording
from cardsflow_fmu.cosim.step_loop import StepLoop
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.utils.arrays import FloatArray

from .by_role import C_MODELS, missing_in_c, require_in_c
from .native.binding import native_library
from .native.loop_tables import loop_tables
from .native.opened_model import OpenedModel

_CHUNK = 256  # steps per call, about 3 ms, so that Ctrl-C and `watch` take effect
_ADVICE = "run it with `compute = 'python'`, or as FMUs"


def runs_in_c(experiment: Experiment) -> bool:
    """Return whether a run of the experiment is one loop in C."""
    run = experiment.run
    return run.compute == "c" and run.coupling == "direct" and missing_in_loop(experiment) is None


def missing_in_loop(experiment: Experiment) -> str | None:
    """Return a part of a run that C does not support, or None."""
    part = _unsupported_part(experiment, experiment.columns)
    requirements = (missing_in_c(experiment, name) for name in experiment.columns)
    return part or next((text for text in requirements if text is not None), None)


def require_native(experiment: Experiment, names: Sequence[str]) -> None:
    """Raise an error if an experiment requires Python or DART.

    Args:
        experiment: The experiment.
        names: Names of its models.

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


class NativeLoop(StepLoop):
    """Run of an experiment that computes only in C, with the methods of `master.Master`.

    Raises:
        InputError: The experiment requires Python or DART. The message names the requirement.
    """

    def __init__(self, experiment: Experiment) -> None:
        self._names = experiment.columns
        require_native(experiment, self._names)
        self._library = native_library()
        self._models = [C_MODELS[name](experiment) for name in self._names]
        parts = [
            WiredPorts(name, model.ports, model.inputs, model.outputs)
            for name, model in zip(self._names, self._models, strict=True)
        ]
        self._opened = [m.opened for m in self._models if isinstance(m.opened, OpenedModel)]
        handles = (ctypes.c_void_p * len(parts))(*(model.handle for model in self._opened))
        self._loop: ctypes.c_void_p | None = ctypes.c_void_p(
            self._library.native_loop_open(len(parts), handles)
        )
        self._initialize()
        self._experiment, run = experiment, experiment.run
        self._step, self.count = run.step, run.steps + 1
        self.names, self.units, _ = columns_of(parts)
        every = round(experiment.controller.period / run.step)
        self._every = dict.fromkeys(self._names, 1) | {"controller": every}
        self._has_run, self._done, self._times = False, 0, np.zeros(self.count)
        self._plan(parts)

    def _require_ready(self) -> None:
        if self._loop is None or self._has_run:
            raise InputError(
                "a native loop can run only once and not after it is closed; create a new one"
            )
        self._has_run = True

    def _steps(self, rows: FloatArray, pacer: Pacer | None) -> Iterator[int]:
        """Execute a chunk of steps per iteration and yield the number of completed steps."""
        assert pacer is None, "real time is not supported"
        steps = self.count - 1
        while self._done < steps:
            failure = self._advance(min(_CHUNK, steps - self._done), rows)
            yield self._done
            if failure is not None:
                raise failure
        self._library.native_loop_record(self._loop, steps * self._step, rows[steps:].ctypes.data)
        self._recorded = self.count

    def _recording(self, rows: FloatArray, failure: CardsflowError | None) -> Recording:
        every, first = self._every["controller"], self._tick_shows
        shown = np.arange(first, first + self._done, every)
        times = self._times[: self._done : every]
        return Recording(self.names, rows, self.units, shown, times, failure)

    def close(self) -> None:
        """Free the loop."""
        loop, self._loop = self._loop, None
        if loop is not None:
            self._library.native_loop_close(loop)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _advance(self, count: int, rows: FloatArray) -> SimulationError | None:
        """Execute steps in C and return the failure, or None."""
        first, times = self._done, self._times
        assert rows.flags.c_contiguous
        assert first + count < min(len(rows), len(times) + 1)
        done = (ctypes.c_int64 * 2)()
        failed = self._library.native_loop_run(
            self._loop,
            self._step,
            first,
            count,
            rows[first:].ctypes.data,
            times[first:].ctypes.data,
            done,
        )
        self._done, self._recorded = first + done[0], first + done[1]
        return self._error(failed, f"at t = {self._done * self._step:.6g} s") if failed else None

    def _plan(self, parts: Sequence[WiredPorts]) -> None:
        """Pass the order of models in a step, the copied signals and the columns to C."""
        experiment = self._experiment
        tables = loop_tables(parts, experiment.wiring, experiment.stepping, self._every)
        self._tables = tables  # C stores pointers to the tables
        controller = self._names.index("controller")
        stage = next(int(turn[3]) for turn in tables.turns if turn[0] == controller)
        self._tick_shows = int(stage >= tables.before)
        failed = self._library.native_loop_plan(
            self._loop,
            *(len(tables.turns), tables.turns.ctypes.data),
            *(len(tables.copies), tables.copies.ctypes.data, tables.changes.ctypes.data),
            *(len(tables.columns), tables.columns.ctypes.data),
            *(tables.before, tables.timer.ctypes.data),
        )
        assert not failed

    def _error(self, failed: int, when: str) -> SimulationError:
        text = self._opened[failed - 1].message
        return SimulationError(f"the {self._names[failed - 1]} failed {when}: {text}")

    def _initialize(self) -> None:
        failed = self._library.native_loop_initialize(self._loop)
        if failed:
            self.close()
            raise InputError(self._opened[failed - 1].message)  # same as of a single model


def run_batch(experiments: Sequence[Experiment], threads: int = 1) -> list[Recording]:
    """Run several experiments in parallel threads.

    Args:
        experiments: The experiments.
        threads: Maximum number of parallel runs, at least 1.

    Returns:
        Recordings in the order of the experiments. The recording of a failed run contains the
        failure.

    Raises:
        InputError: An experiment requires Python or DART, or `threads` is not positive.
    """
    if threads < 1:
        raise InputError(f"threads must be at least 1, not {threads}")
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(_run_one, experiments))


def _run_one(experiment: Experiment) -> Recording:
    with NativeLoop(experiment) as loop:
        return loop.run()
