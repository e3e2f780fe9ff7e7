"""Connections of outputs to inputs: by equal names or explicit wiring, with unit conversion."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Protocol

from addin_sdfusion.robot import InputError, UnknownNameError
from cardsflow_fmu.cosim.signals.units import Conversion, conversion

from .participant import Copy, Form, Wired

Wiring = Mapping[str, str | float]


class Ported(Protocol):
    """Object with named inputs and outputs."""

    @property
    def name(self) -> str:
        """Name in the wiring."""

    @property
    def input_names(self) -> tuple[str, ...]:
        """Names of the inputs."""

    @property
    def output_names(self) -> tuple[str, ...]:
        """Names of the outputs."""


def connect(
    participants: Sequence[Wired],
    wiring: Wiring,
    *,
    by_name: bool = True,
    changes: Mapping[str, Conversion] | None = None,
) -> dict[str, list[Copy]]:
    """Connect participants. Inputs with a constant value are set once, here.

    Args:
        participants: Participants with different names.
        wiring: An output or a number for each input that is not connected by equal names, all by
            full name. The name of a group of ports, such as `plant.q` for `plant.q.elbow` and
            `plant.q.wrist`, or of an array connects its elements in order.
        by_name: Whether an input without wiring uses the output of the same name, which must
            exist. Otherwise it stays at its start value.

    Returns:
        Copies to make before a participant steps, by the participant's name.

    Raises:
        InputError: An input has no source, or sizes or units do not match.
        UnknownNameError: The wiring names a port that does not exist.
    """
    by_target = routes(participants, wiring, by_name=by_name)
    _set_constants(participants, by_target)
    return {p.name: _copies(p, participants, by_target, changes or {}) for p in participants}


def routes(
    participants: Sequence[Ported], wiring: Wiring, *, by_name: bool = True
) -> dict[str, str | float]:
    """Return the source of each input: an output or a number, all by full name.

    Arguments and errors are those of `connect`, except for units.
    """
    outputs = [f"{p.name}.{name}" for p in participants for name in p.output_names]
    inputs = [f"{p.name}.{name}" for p in participants for name in p.input_names]
    by_target = _expand_wiring(wiring, inputs, outputs)
    if by_name:
        _add_equal_names(by_target, inputs, outputs)
    return by_target


def members(name: str, names: Iterable[str]) -> list[str]:
    """Return the port with a name, or the ports of the group or array with that name, in order."""
    names = list(names)
    if name in names:
        return [name]
    return [other for other in names if other.startswith((f"{name}.", f"{name}["))]


def _expand_wiring(
    wiring: Wiring, inputs: Sequence[str], outputs: Sequence[str]
) -> dict[str, str | float]:
    """Return the explicit wiring with one source per input."""
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
            problem = f"{source} has {_count(sources)}, {target} has {_count(targets)}"
            raise InputError(f"sizes do not match: {problem}", key=f"wiring.{target}")
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
    gaps = []
    for target in inputs:
        if target in by_target:
            continue
        sources = named.get(target.split(".", 1)[1], [])
        if len(sources) == 1:
            by_target[target] = sources[0]
        else:
            candidates = f"outputs with this name: {', '.join(sources)}" if sources else ""
            gaps.append(f"{target} ({candidates or 'no output has this name'})")
    if gaps:
        fmu, _, name = gaps[0].partition(" ")[0].partition(".")
        raise InputError(
            f"each input requires exactly one source: {'; '.join(gaps)}. For an external FMU, name "
            f"its variables for the ports in inputs and outputs of [fmus.{fmu}]. Otherwise, "
            f'specify an output or a number in [wiring.{fmu}], such as "{name}" = 0.0',
            key="wiring",
        )


def _set_constants(participants: Sequence[Wired], by_target: Wiring) -> None:
    """Set the inputs with constant values."""
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
        for k, name in enumerate(target.input_names):
            full = f"{target.name}.{name}"
            route = by_target.get(full)
            if isinstance(route, str) and route in where:
                j = where[route]
                change = changes.get(full) or _conversion(source, j, target, k)
                form = Form.EXACT if change.is_identity else Form.SCALED
                copies.append(Copy(source.outputs, j, target.inputs, k, form, change))
    return copies


def _conversion(source: Wired, j: int, target: Wired, k: int) -> Conversion:
    output, input_ = source.output_names[j], target.input_names[k]
    try:
        return conversion(source.units.get(output), target.units.get(input_))
    except InputError as error:
        route = f"{source.name}.{output} -> {target.name}.{input_}"
        raise InputError(f"{route}: {error.problem}", key="wiring") from None
