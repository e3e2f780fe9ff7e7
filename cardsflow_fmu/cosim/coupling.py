"""Coupling schemes: the order of participants in a step, and the outputs that each reads."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

from addin_sdfusion.robot import InputError, UnknownNameError

Scheme = Literal["sampled", "jacobi", "gauss_seidel"]


@dataclass(frozen=True, slots=True)
class Coupling:
    """A coupling scheme.

    `sampled`: The participants in `order` tick first, each with the current outputs. Their outputs
    are held while the others advance together. Each row contains the commands that act from its
    time on. Use it for a sampled controller and its plant.

    `jacobi`: All participants advance together, with the outputs at the beginning of the step.

    `gauss_seidel`: The participants advance in the given order, each with the newest outputs.

    Attributes:
        scheme: `sampled`, `jacobi` or `gauss_seidel`.
        order: Names of participants: those that tick, or, for `gauss_seidel`, all.
    """

    scheme: Scheme = "sampled"
    order: tuple[str, ...] = ("controller",)

    def stages(self, names: Sequence[str]) -> tuple[list[list[str]], int]:
        """Group the participants that use the same outputs of the others.

        Returns:
            The groups, in order, and the number of groups that step before a row is recorded.

        Raises:
            InputError: The order does not match the participants.
        """
        order = () if self.scheme == "jacobi" else self.order
        _check(order, names)
        rest = [name for name in names if name not in order]
        if self.scheme == "gauss_seidel" and rest:
            raise InputError(f"the order does not contain {', '.join(rest)}", key="order")
        groups = [[name] for name in order] + ([rest] if rest else [])
        return groups, len(order) if self.scheme == "sampled" else 0


def _check(order: Iterable[str], names: Sequence[str]) -> None:
    seen: set[str] = set()
    for name in order:
        if name not in names:
            raise UnknownNameError("participant", name, names, key="order")
        if name in seen:
            raise InputError(f"{name!r} occurs twice in the order", key="order")
        seen.add(name)
