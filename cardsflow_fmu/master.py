"""The fixed-step co-simulation master.

Coupling scheme `sampled`: at every tick the outputs of plant and reference are read, the controller
is stepped with them, and its forces are held while the plant and the reference advance. A
controller may tick every k-th communication step; its forces then hold for k steps.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from addin_sdfusion.robot import CardsflowError, InputError, SimulationError, UnknownNameError

from .participants import FloatArray, Participant
from .ports import SOLVE_TIME

COUPLING = "sampled"

Indices = slice | list[int]
Progress = Callable[[int], None]


@dataclass(frozen=True, slots=True)
class _Copy:
    """Outputs of one participant that are inputs of another."""

    source: FloatArray
    source_indices: Indices
    target: FloatArray
    target_indices: Indices

    def __call__(self) -> None:
        self.target[self.target_indices] = self.source[self.source_indices]


@dataclass(frozen=True)
class Recording:
    """What a run gave, one row a communication point.

    Attributes:
        names: Name of every column; the first is `time`.
        rows: Shape (rows, len(names)).
        ticks: Rows at which the controller was stepped.
        solve_times: How long the controller took at each tick, in [s], where it tells. Apart from
            the rows, which are equal whenever the same experiment is run.
        failure: Why the run ended early, None when it is complete.
    """

    names: tuple[str, ...]
    rows: FloatArray
    ticks: list[int]
    solve_times: list[float]
    failure: CardsflowError | None


class Master:
    """Steps a plant, its controller and a reference.

    Args:
        plant, controller, reference: The participants, initialised.
        wiring: Outputs, or numbers, for inputs that are not wired by equal names, by full name.
        step: Communication step, in [s].
        steps: Number of communication steps.
        ticks_every: Communication steps a tick of the controller.

    Raises:
        InputError: An input has no output to take its value from.
        UnknownNameError: The wiring names a port that does not exist.
    """

    def __init__(
        self,
        plant: Participant,
        controller: Participant,
        reference: Participant,
        wiring: Mapping[str, str | float],
        *,
        step: float,
        steps: int,
        ticks_every: int = 1,
    ) -> None:
        self._plant, self._controller, self._reference = plant, controller, reference
        self._step, self._steps, self._ticks_every = step, steps, ticks_every
        participants = [plant, controller, reference]
        held = {name: value for name, value in wiring.items() if not isinstance(value, str)}
        routes = _routes(participants, wiring)
        _hold(participants, held)
        self._to_controller = _copies(controller, participants, routes)
        self._to_plant = _copies(plant, participants, routes)
        names, self._columns = ["time"], []
        for p in (plant, reference, controller):
            kept = [k for k, name in enumerate(p.output_names) if name != SOLVE_TIME]
            columns = slice(len(names), len(names) + len(kept))
            self._columns.append((p.outputs, _indices(tuple(kept)), columns))
            names += [p.output_names[k] for k in kept]
        self.names = tuple(names)
        timed = SOLVE_TIME in controller.output_names
        self._timer = controller.output_names.index(SOLVE_TIME) if timed else None

    def run(self, progress: Progress | None = None) -> Recording:
        """Run to the end, to the first failure, or until Ctrl-C.

        Args:
            progress: Called now and then with the number of steps done.
        """
        rows = np.empty((self._steps + 1, len(self.names)))
        ticks: list[int] = []
        self._solve_times: list[float] = []
        failure: CardsflowError | None = None
        self._recorded = done = 0
        with _interruptible() as interrupted:
            try:
                for done in self._loop(rows, ticks):
                    if interrupted:
                        raise SimulationError("interrupted")
                    if progress and done % 128 == 0:
                        progress(done)
            except CardsflowError as error:
                failure = error
            except KeyboardInterrupt:
                failure = SimulationError("interrupted")
        if progress:
            progress(done)
        return Recording(self.names, rows[: self._recorded], ticks, self._solve_times, failure)

    def _loop(self, rows: FloatArray, ticks: list[int]) -> Iterator[int]:
        """One communication step an iteration; yields the number of steps done."""
        plant, controller, reference = self._plant, self._controller, self._reference
        step, ticks_every = self._step, self._ticks_every
        period = ticks_every * step
        for k in range(self._steps):
            t = k * step
            if k % ticks_every == 0:
                for copy in self._to_controller:
                    copy()
                controller.step(t, period)
                ticks.append(k)
                if self._timer is not None:
                    self._solve_times.append(float(controller.outputs[self._timer]))
            self._record(rows[k], t)
            for copy in self._to_plant:
                copy()
            plant.step(t, step)
            reference.step(t, step)
            yield k + 1
        self._record(rows[self._steps], self._steps * step)

    def _record(self, row: FloatArray, t: float) -> None:
        row[0] = t
        for outputs, indices, columns in self._columns:
            row[columns] = outputs[indices]
        self._recorded += 1


def _routes(participants: list[Participant], wiring: Mapping[str, str | float]) -> dict[str, str]:
    """The full name of the output that feeds each input, by the input's full name.

    It is empty for an input that is held at a number.
    """
    outputs = [f"{p.name}.{name}" for p in participants for name in p.output_names]
    inputs = [f"{p.name}.{name}" for p in participants for name in p.input_names]
    for target, source in wiring.items():
        if target not in inputs:
            raise UnknownNameError("input", target, inputs, key="wiring")
        if isinstance(source, str) and source not in outputs:
            raise UnknownNameError("output", source, outputs, key=f"wiring.{target}")
    routes = {t: source if isinstance(source, str) else "" for t, source in wiring.items()}
    for p in participants:
        for name in p.input_names:
            target = f"{p.name}.{name}"
            sources = [o for o in outputs if o.split(".", 1)[1] == name]
            if target not in routes and len(sources) != 1:
                found = f"outputs of that name: {', '.join(sources) or 'none'}"
                raise InputError(f"input {target} needs one output; {found}", key="wiring")
            routes.setdefault(target, sources[0] if sources else "")
    return routes


def _hold(participants: list[Participant], held: Mapping[str, float]) -> None:
    """Set the inputs that are held at a number, once."""
    for p in participants:
        for k, name in enumerate(p.input_names):
            if f"{p.name}.{name}" in held:
                p.inputs[k] = held[f"{p.name}.{name}"]


def _copies(
    target: Participant, participants: list[Participant], routes: Mapping[str, str]
) -> list[_Copy]:
    copies = []
    for source in participants:
        where = {f"{source.name}.{name}": k for k, name in enumerate(source.output_names)}
        pairs = [
            (where[routes[f"{target.name}.{name}"]], k)
            for k, name in enumerate(target.input_names)
            if routes[f"{target.name}.{name}"] in where
        ]
        if pairs:
            froms, tos = zip(*pairs, strict=True)
            copies.append(_Copy(source.outputs, _indices(froms), target.inputs, _indices(tos)))
    return copies


def _indices(numbers: tuple[int, ...]) -> Indices:
    """A slice where the numbers follow one another: copying is then cheapest."""
    if not numbers:
        return []
    first, last = numbers[0], numbers[-1]
    follow_on = list(numbers) == list(range(first, last + 1))
    return slice(first, last + 1) if follow_on else list(numbers)


@contextmanager
def _interruptible() -> Iterator[list[int]]:
    """Collects the first Ctrl-C or SIGTERM instead of raising in the middle of a step.

    A second one raises KeyboardInterrupt: a single step may be endless.
    """
    pressed: list[int] = []

    def press(number: int, frame: object) -> None:
        if pressed:
            raise KeyboardInterrupt
        pressed.append(number)

    with _handling(press):
        yield pressed


@contextmanager
def ignoring_interrupts() -> Iterator[None]:
    """Ctrl-C and SIGTERM do nothing meanwhile: for the seconds in which results are written."""
    with _handling(signal.SIG_IGN):
        yield


@contextmanager
def _handling(handler: Any) -> Iterator[None]:
    """Another handler for Ctrl-C and SIGTERM, in the main thread, which alone may set one."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(number, handler) for number in numbers]
    try:
        yield
    finally:
        for number, previous in zip(numbers, before, strict=True):
            signal.signal(number, previous)
