"""Connections of outputs to inputs: by equal names or explicit wiring, with unit conversion."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from addin_sdfusion.robot import InputError, UnknownNameError
from cardsflow_fmu.cosim.signals.units import Conversion, conversion
from cardsflow_fmu.utils.arrays import FloatArray

from .participant import Wired

Indices = slice | list[int]
Wiring = Mapping[str, str | float]


class Ported(Protocol):
    """Something with named inputs and outputs."""

    @property
    def name(self) -> str:
        """Its name in the wiring."""

    @property
    def input_names(self) -> tuple[str, ...]:
        """Names of its inputs."""

    @property
    def output_names(self) -> tuple[str, ...]:
        """Names of its outputs."""


@dataclass(frozen=True, slots=True)
class Copy:
    """Outputs of one participant that are inputs of another."""

    source: FloatArray
    source_indices: Indices
    target: FloatArray
    target_indices: Indices

    def __call__(self) -> None:
        """Copy."""
        self.target[self.target_indices] = self.source[self.source_indices]


@dataclass(frozen=True, slots=True)
class RowCopy(Copy):
    """The same of neighbours to neighbours, the cheapest: views of both, made once."""

    given: FloatArray
    taken: FloatArray

    def __call__(self) -> None:
        """Copy."""
        self.taken[:] = self.given


@dataclass(frozen=True, slots=True)
class ConvertingCopy(Copy):
    """The same where at least one value changes its unit."""

    factors: FloatArray
    offsets: FloatArray

    def __call__(self) -> None:
        """Copy and convert."""
        values = self.source[self.source_indices]
        self.target[self.target_indices] = self.factors * values + self.offsets


def connect(
    participants: Sequence[Wired],
    wiring: Wiring,
    *,
    by_name: bool = True,
    changes: Mapping[str, Conversion] | None = None,
) -> dict[str, list[Copy]]:
    """Wire participants; inputs that are held at a number are set here, once.

    Args:
        participants: With different names.
        wiring: An output, or a number, for each input that is not wired by equal names; both by
            full name. A name of a group of ports, as `plant.q` does for `plant.q.elbow`
            and `plant.q.wrist`, or for an array, wires them in order.
        by_name: Whether an input that the wiring leaves out takes the output of the same name, and
            must have one. Otherwise it stays at its start value.
        changes: Conversions of inputs by full name, where they are not those of the units.

    Returns:
        What has to be copied before a participant steps, by its name.

    Raises:
        InputError: An input has no output to take its value from, or sizes or units do not fit.
        UnknownNameError: The wiring names a port that does not exist.
    """
    by_target = routes(participants, wiring, by_name=by_name)
    _hold(participants, by_target)
    return {p.name: _copies(p, participants, by_target, changes or {}) for p in participants}


def routes(
    parts: Sequence[Ported], wiring: Wiring, *, by_name: bool = True
) -> dict[str, str | float]:
    """The output, or the number, that feeds each input; all by full name.

    Arguments and errors as for `connect`, but for units.
    """
    outputs = [f"{p.name}.{name}" for p in parts for name in p.output_names]
    inputs = [f"{p.name}.{name}" for p in parts for name in p.input_names]
    by_target = _explicit(wiring, inputs, outputs)
    if by_name:
        _add_equal_names(by_target, inputs, outputs)
    return by_target


def members(name: str, names: Iterable[str]) -> list[str]:
    """The ports of a name: itself, or those of its group or its array, in order."""
    names = list(names)
    if name in names:
        return [name]
    return [other for other in names if other.startswith((f"{name}.", f"{name}["))]


def indices(numbers: Sequence[int]) -> Indices:
    """A slice where the numbers follow one another: copying is then cheapest."""
    if not numbers:
        return []
    first, last = numbers[0], numbers[-1]
    follow_on = list(numbers) == list(range(first, last + 1))
    return slice(first, last + 1) if follow_on else list(numbers)


def runs(numbers: Sequence[int]) -> list[slice]:
    """Slices that hold these numbers in their order, as few as can be."""
    found: list[slice] = []
    for number in numbers:
        if found and found[-1].stop == number:
            found[-1] = slice(found[-1].start, number + 1)
        else:
            found.append(slice(number, number + 1))
    return found


def _explicit(
    wiring: Wiring, inputs: Sequence[str], outputs: Sequence[str]
) -> dict[str, str | float]:
    """The explicit wiring, a source an input."""
    by_target: dict[str, str | float] = {}
    for target, source in wiring.items():
        targets = members(target, inputs)
        if not targets:
            raise UnknownNameError("input", target, inputs, key="wiring")
        if not isinstance(source, str):
            by_target |= dict.fromkeys(targets, source)
            continue
        sources = members(source, outputs)
        if not sources:
            raise UnknownNameError("output", source, outputs, key=f"wiring.{target}")
        if len(sources) != len(targets):
            what = f"{source} has {_count(sources)}, {target} has {_count(targets)}"
            raise InputError(f"sizes do not fit: {what}", key=f"wiring.{target}")
        by_target |= dict(zip(targets, sources, strict=True))
    return by_target


def _count(ports: Sequence[str]) -> str:
    return f"{len(ports)} {'value' if len(ports) == 1 else 'values'}"


def _add_equal_names(
    by_target: dict[str, str | float], inputs: Sequence[str], outputs: Sequence[str]
) -> None:
    named: dict[str, list[str]] = {}
    for output in outputs:
        named.setdefault(output.split(".", 1)[1], []).append(output)
    for target in inputs:
        if target in by_target:
            continue
        sources = named.get(target.split(".", 1)[1], [])
        if len(sources) != 1:
            found = f"outputs of that name: {', '.join(sources) or 'none'}"
            raise InputError(f"input {target} needs one output; {found}", key="wiring")
        by_target[target] = sources[0]


def _hold(participants: Sequence[Wired], by_target: Wiring) -> None:
    """Set the inputs that are held at a number, once."""
    for p in participants:
        for k, name in enumerate(p.input_names):
            value = by_target.get(f"{p.name}.{name}")
            if value is not None and not isinstance(value, str):
                p.inputs[k] = value


def _copies(
    target: Wired,
    participants: Sequence[Wired],
    by_target: Wiring,
    changes: Mapping[str, Conversion],
) -> list[Copy]:
    copies = []
    for source in participants:
        where = {f"{source.name}.{name}": k for k, name in enumerate(source.output_names)}
        pairs, made = [], []
        for k, name in enumerate(target.input_names):
            full = f"{target.name}.{name}"
            route = by_target.get(full)
            if isinstance(route, str) and route in where:
                j = where[route]
                pairs.append((j, k))
                made.append(changes.get(full) or _conversion(source, j, target, k))
        if pairs:
            copies.append(_copy(source, target, pairs, made))
    return copies


def _copy(
    source: Wired,
    target: Wired,
    pairs: Sequence[tuple[int, int]],
    changes: Sequence[Conversion],
) -> Copy:
    froms, tos = zip(*pairs, strict=True)
    places = (source.outputs, indices(froms), target.inputs, indices(tos))
    if all(change.is_identity for change in changes):
        if isinstance(places[1], slice) and isinstance(places[3], slice):
            return RowCopy(*places, places[0][places[1]], places[2][places[3]])
        return Copy(*places)
    factors = np.array([change.factor for change in changes])
    return ConvertingCopy(*places, factors, np.array([change.offset for change in changes]))


def _conversion(source: Wired, j: int, target: Wired, k: int) -> Conversion:
    output, input_ = source.output_names[j], target.input_names[k]
    try:
        return conversion(source.units.get(output), target.units.get(input_))
    except InputError as error:
        route = f"{source.name}.{output} -> {target.name}.{input_}"
        raise InputError(f"{route}: {error.what}", key="wiring") from None
