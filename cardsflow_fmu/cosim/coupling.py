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

    `sampled`: the participants of `order` tick first, each with the outputs of this very tick;
    their outputs are held while the others advance, together. What is recorded for a time are the
    commands that act from then on. It is how a sampled controller drives a plant.

    `jacobi`: all advance together, each with what the others gave at the beginning of the step.

    `gauss_seidel`: one after another in the given order, each with the newest outputs.

    Attributes:
        scheme: `sampled`, `jacobi` or `gauss_seidel`.
        order: Names of participants: those that tick, or, for `gauss_seidel`, all.
    """

    scheme: Scheme = "sampled"
    order: tuple[str, ...] = ("controller",)

    def stages(self, names: Sequence[str]) -> tuple[list[list[str]], int]:
        """The participants in groups that see the same outputs of the others.

        Returns:
            The groups, in order; and after how many of them a step is recorded.

        Raises:
            InputError: The order does not fit the participants.
        """
        order = () if self.scheme == "jacobi" else self.order
        _check(order, names)
        rest = [name for name in names if name not in order]
        if self.scheme == "gauss_seidel" and rest:
            raise InputError(f"the order lacks {', '.join(rest)}", key="order")
        groups = [[name] for name in order] + ([rest] if rest else [])
        return groups, len(order) if self.scheme == "sampled" else 0


def _check(order: Iterable[str], names: Sequence[str]) -> None:
    seen: set[str] = set()
    for name in order:
        if name not in names:
            raise UnknownNameError("participant", name, names, key="order")
        if name in seen:
            raise InputError(f"{name!r} stands in it twice", key="order")
        seen.add(name)
