"""Native loop: plant, controller and reference in C, thousands of steps per call.

All participants are models of native FMUs; a step runs no Python. A call releases Python's GIL, so
that loops can run in parallel threads.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import CardsflowError, InputError, SimulationError
from cardsflow_fmu.cosim.master import columns_of
from cardsflow_fmu.cosim.pacing import Pacer
from cardsflow_fmu.cosim.participant import WiredPorts
from cardsflow_fmu.cosim.recording import Recording
from cardsflow_fmu.cosim.signals.ports import SOLVE_TIME
from cardsflow_fmu.cosim.step_loop import StepLoop
from cardsflow_fmu.cosim.wiring import ConvertingCopy, Copy, connect
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.utils.arrays import FloatArray

from .by_role import C_MODELS, missing_in_c, require_in_c
from .native.binding import native_library
from .native.opened_model import OpenedModel

_CHUNK = 1024  # steps per call, about ten milliseconds, so that Ctrl-C takes effect
_INSTEAD = "run it with `compute = 'python'`, or as FMUs"


def runs_in_c(experiment: Experiment) -> bool:
    """Return whether a run of the experiment is one loop in C."""
    run = experiment.run
    return run.compute == "c" and run.coupling == "direct" and missing_in_loop(experiment) is None


def missing_in_loop(experiment: Experiment) -> str | None:
    """Name a part of a run that C does not support; None if there is none."""
    lacking = _lacking(experiment, experiment.columns)
    missing = (missing_in_c(experiment, name) for name in experiment.columns)
    return lacking or next((what for what in missing if what is not None), None)


def require_native(experiment: Experiment, names: Sequence[str]) -> None:
    """Raise an error if an experiment requires more than the models in C.

    Args:
        experiment: The experiment.
        names: Its models.

    Raises:
        InputError: It does. The message names the requirement.
    """
    lacking = _lacking(experiment, names)
    if lacking is not None:
        raise InputError(
            f"a native loop does not support {lacking}; {_INSTEAD}", file=experiment.file
        )
    for name in names:
        require_in_c(experiment, name, _INSTEAD)


def _lacking(experiment: Experiment, names: Sequence[str]) -> str | None:
    """Name a part of the run other than models that C does not support; None if there is none."""
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
    """Experiment that computes in C only, with the methods of `master.Master`.

    Raises:
        InputError: It requires Python or DART. The message names the requirement.
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
                "a native loop can run only once, before it is closed; create another one"
            )
        self._has_run = True

    def _steps(self, rows: FloatArray, pacer: Pacer | None) -> Iterator[int]:
        """Take a chunk of steps per iteration."""
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
        shown = list(range(first, first + self._done, every))
        times = self._times[: self._done : every].tolist()
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
        """Take steps in C; return the failure, or None."""
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
        """Pass the order of a step, its copies and its columns to C."""
        experiment = self._experiment
        copies = connect(parts, experiment.wiring)
        numbers = {part.name: k for k, part in enumerate(parts)}
        groups, before = experiment.stepping.stages(list(numbers))
        turns: list[list[int]] = []
        routes: list[tuple[int, ...]] = []
        changes: list[tuple[float, ...]] = []
        for stage, group in enumerate(groups):
            for name in group:
                own = [route for copy in copies[name] for route in _routes(copy, name, parts)]
                turns.append([numbers[name], self._every[name], len(own), stage])
                routes += [places for places, _ in own]
                changes += [change for _, change in own]
        controller = parts[numbers["controller"]]
        stages = {name: stage for stage, group in enumerate(groups) for name in group}
        self._tick_shows = int(stages["controller"] >= before)
        timer = [numbers["controller"], _places(controller).index(SOLVE_TIME)]
        columns = [
            [k, _places(part).index(name)]
            for k, part in enumerate(parts)
            for name in part.output_names
            if name != SOLVE_TIME
        ]
        self._tables: list[NDArray[Any]] = [  # C keeps pointers to them
            *(np.array(t, dtype=np.int32) for t in (turns, routes, columns, timer)),
            np.array(changes, dtype=np.float64),
        ]
        order, routes_, columns_, timer_, changes_ = [table.ctypes.data for table in self._tables]
        refused = self._library.native_loop_plan(
            self._loop,
            *(len(turns), order),
            *(len(routes), routes_, changes_),
            *(len(columns), columns_),
            *(before, timer_),
        )
        assert not refused

    def _error(self, failed: int, when: str) -> SimulationError:
        text = self._opened[failed - 1].message
        return SimulationError(f"the {self._names[failed - 1]} failed {when}: {text}")

    def _initialize(self) -> None:
        failed = self._library.native_loop_initialize(self._loop)
        if failed:
            self.close()
            raise InputError(self._opened[failed - 1].message)  # as a model alone


def run_batch(experiments: Sequence[Experiment], threads: int = 1) -> list[Recording]:
    """Run several experiments in threads.

    Args:
        experiments: The experiments.
        threads: Number of simultaneous runs, from 1 on.

    Returns:
        Their recordings, in order. A recording of a failed run contains its failure.

    Raises:
        InputError: An experiment requires Python or DART, or `threads` is not positive.
    """
    if threads < 1:
        raise InputError(f"threads must be positive, not {threads}")
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(_run_one, experiments))


def _run_one(experiment: Experiment) -> Recording:
    with NativeLoop(experiment) as loop:
        return loop.run()


def _routes(
    copy: Copy, target: str, parts: Sequence[WiredPorts]
) -> list[tuple[tuple[int, ...], tuple[float, float]]]:
    """Return the routes of a copy: source, index, target, index; and factor and offset."""
    source = next(k for k, part in enumerate(parts) if part.outputs is copy.source)
    end = next(k for k, part in enumerate(parts) if part.name == target)
    skipped = len(parts[source].input_names)
    froms = np.arange(len(parts[source].output_names))[copy.source_indices] + skipped
    tos = np.arange(len(parts[end].input_names))[copy.target_indices]
    factors, offsets = np.ones(len(froms)), np.zeros(len(froms))
    if isinstance(copy, ConvertingCopy):
        factors, offsets = copy.factors, copy.offsets
    return [
        ((source, int(a), end, int(b)), (float(c), float(d)))
        for a, b, c, d in zip(froms, tos, factors, offsets, strict=True)
    ]


def _places(part: WiredPorts) -> tuple[str, ...]:
    """Return inputs and outputs in the order of the values."""
    return (*part.input_names, *part.output_names)
