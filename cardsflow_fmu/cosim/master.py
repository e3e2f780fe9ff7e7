"""Fixed-step co-simulation master for any number of participants."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from addin_sdfusion.robot import CardsflowError, InputError
from cardsflow_fmu.cosim.signals.ports import SOLVE_TIME
from cardsflow_fmu.cosim.signals.units import Conversion
from cardsflow_fmu.utils.arrays import FloatArray

from .coupling import Coupling
from .pacing import Pacer
from .participant import Participant, Wired
from .recording import NumberLog, Recording
from .step_loop import StepLoop
from .wiring import Copy, Wiring, connect, consecutive_slices


@dataclass(frozen=True, slots=True)
class _Turn:
    """Participant in the order of a step.

    Attributes:
        step: Function that steps the participant.
        copies: Copies to its inputs, made before the step.
        every: Number of communication steps per step of the participant.
        is_ticking: Whether it is the controller, whose ticks are recorded.
    """

    step: Callable[[float, float], None]
    copies: list[Copy]
    every: int
    is_ticking: bool


class Master(StepLoop):
    """Master that steps connected participants.

    A participant that is stepped every k-th communication step holds its outputs for k steps.

    Args:
        participants: Initialised participants with different names. Their outputs are the columns,
            in order. If several have the same output name, the participant's name is the prefix.
        wiring: Outputs or numbers for inputs that are not connected by equal names, by full name.
        step: Communication step, in [s].
        steps: Number of communication steps.
        coupling: The coupling scheme.
        every: Communication steps per step of a participant, by its name (default: 1).
        by_name: Whether inputs without wiring use the output of the same name. Otherwise they stay
            at their start values.
        changes: Conversions of inputs by full name, if they differ from those of the units.

    Raises:
        InputError: An input has no source, a size or a unit does not match, or the coupling does
            not match the participants.
        UnknownNameError: The wiring names a port that does not exist.
    """

    _report_every = 128

    def __init__(
        self,
        participants: Sequence[Participant],
        wiring: Wiring,
        *,
        step: float,
        steps: int,
        coupling: Coupling | None = None,
        every: Mapping[str, int] | None = None,
        by_name: bool = True,
        changes: Mapping[str, Conversion] | None = None,
    ) -> None:
        self._step, self.count = step, steps + 1
        by_name_of = {p.name: p for p in participants}
        if len(by_name_of) < len(participants):
            raise InputError("two participants have the same name")
        groups, before = (coupling or Coupling()).stages(list(by_name_of))
        copies = connect(participants, wiring, by_name=by_name, changes=changes)
        ticking = by_name_of.get("controller")
        stages = [
            [
                _Turn(p.step, copies[p.name], (every or {}).get(p.name, 1), p is ticking)
                for p in map(by_name_of.__getitem__, group)
            ]
            for group in groups
        ]
        self._before, self._after = stages[:before], stages[before:]
        self.names, self.units, self._columns = columns_of(participants)
        # Only participants with mapped names and units have warnings.
        self._warnings = [line for p in participants for line in getattr(p, "warnings", ())]
        self._ticks, self._solve_times, self._lateness = NumberLog(), NumberLog(), NumberLog()
        outputs = () if ticking is None else ticking.output_names
        self._controller_outputs = np.empty(0) if ticking is None else ticking.outputs
        self._timer = outputs.index(SOLVE_TIME) if SOLVE_TIME in outputs else None

    def _steps(self, rows: FloatArray, pacer: Pacer | None) -> Iterator[int]:
        """Take one communication step per iteration."""
        self._ticks, self._solve_times, self._lateness = NumberLog(), NumberLog(), NumberLog()
        steps = self.count - 1
        for k in range(steps):
            if pacer is not None:
                self._lateness.append(pacer.wait(k * self._step))
            for stage in self._before:
                self._advance(stage, k, k)
            self._record(rows[k], k * self._step)
            for stage in self._after:
                self._advance(stage, k, k + 1)
            yield k + 1
        if pacer is not None:
            self._lateness.append(pacer.wait(steps * self._step))
        self._record(rows[steps], steps * self._step)

    def _recording(self, rows: FloatArray, failure: CardsflowError | None) -> Recording:
        return Recording(
            self.names,
            rows,
            self.units,
            self._ticks.numbers().astype(np.intp),
            self._solve_times.numbers(),
            failure,
            self._lateness.numbers(),
            self._warnings,
        )

    def _advance(self, stage: Sequence[_Turn], k: int, row: int) -> None:
        """Set the inputs of all participants of a stage, then step them.

        Args:
            stage: The participants.
            k: Number of the step.
            row: First row with the outputs of the step.
        """
        step = self._step
        for turn in stage:
            if k % turn.every == 0:
                for copy in turn.copies:
                    copy()
        for turn in stage:
            if k % turn.every:
                continue
            turn.step(k * step, turn.every * step)
            if turn.is_ticking:
                self._ticks.append(row)
                if self._timer is not None:
                    self._solve_times.append(self._controller_outputs.item(self._timer))

    def _record(self, row: FloatArray, t: float) -> None:
        row[0] = t
        for outputs, columns in self._columns:
            row[columns] = outputs
        self._recorded += 1


def columns_of(
    participants: Sequence[Wired],
) -> tuple[tuple[str, ...], dict[str, str], list[tuple[FloatArray, slice]]]:
    """Return names, units and values of the columns; the values are views of the outputs.

    Args:
        participants: Their outputs are the columns, in order, except solve times.
    """
    count = Counter(name for p in participants for name in p.output_names)
    names, units, columns = ["time"], {"time": "s"}, []
    for p in participants:
        kept = [k for k, name in enumerate(p.output_names) if name != SOLVE_TIME]
        begin = len(names)
        for run in consecutive_slices(kept):
            end = begin + run.stop - run.start
            columns.append((p.outputs[run], slice(begin, end)))
            begin = end
        for k in kept:
            name = p.output_names[k]
            names.append(name if count[name] == 1 else f"{p.name}.{name}")
            units[names[-1]] = p.units[name].name if name in p.units else ""
    return tuple(names), units, columns
