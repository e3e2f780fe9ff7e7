"""What describes a muscle law: parameters, rules between them, command, states, dependencies.

Standard library only: hatch_build.py reads the laws when the package is built.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Mapping
from functools import cache
from types import CodeType
from typing import NamedTuple

MAX_VALUE = 1e9
"""Of winches and heavy cables, in SI units: what none has, and the core still computes with."""


class Parameter(NamedTuple):
    """A number of a muscle law.

    Attributes:
        name: Its name in files.
        unit: Its unit, as FMI writes units.
        default: What holds if it is not given; None if it must be.
        low: Smallest value.
        high: Largest value.
        meaning: What it is.
        open_low: Whether it must be above `low`.
    """

    name: str
    unit: str
    default: float | None
    low: float
    high: float
    meaning: str
    open_low: bool = False

    @property
    def bounds(self) -> str:
        """Its bounds in words: `above 0, and 1 at most`."""
        if math.isinf(self.low):
            return "finite" if math.isinf(self.high) else f"{self.high:g} at most"
        least = f"above {self.low:g}" if self.open_low else f"{self.low:g} or more"
        return least if math.isinf(self.high) else f"{least}, and {self.high:g} at most"

    def allows(self, value: float) -> bool:
        """Return whether a value is finite and within the bounds."""
        above = self.low < value if self.open_low else self.low <= value
        return math.isfinite(value) and above and value <= self.high


class Command(NamedTuple):
    """What drives a muscle.

    Attributes:
        name: What it is.
        unit: Its unit, as FMI writes units.
        low: Its smallest value: a number, or a formula of parameters.
        high: Its largest value, likewise.
    """

    name: str
    unit: str
    low: float | str
    high: float | str


class LawState(NamedTuple):
    """A number that a muscle remembers.

    Attributes:
        name: What it is; with the muscle's name a variable: `activation.biceps`.
        unit: Its unit, as FMI writes units.
        where: A condition on parameters under which the muscle has it; empty if it always has.
            States that a muscle may lack come last.
        at_start: What it follows from at the start, of u (command), l (length), v (rate).
    """

    name: str
    unit: str
    where: str = ""
    at_start: str = "ulv"


class Term(NamedTuple):
    """A number that follows from parameters, for the rules behind it.

    Attributes:
        name: Its name in formulas; in C also the function `<law>_<name>(p)`.
        formula: Of parameters and of terms before it.
    """

    name: str
    formula: str


class Rule(NamedTuple):
    """A condition between parameters; each of them is within its own bounds.

    Attributes:
        condition: Of parameters and of terms before it: `rest_low <= rest_high`.
        why: What it means, where the condition does not say it.
    """

    condition: str
    why: str = ""

    @property
    def text(self) -> str:
        """What a muscle that breaks it is rejected with."""
        return f"{self.condition} must hold" + (f": {self.why}" if self.why else "")


class MuscleLawDefinition(NamedTuple):
    """How the tension of a muscle follows from its command, its length and its speed.

    Conditions and formulas are written as in Python, with comparisons, `and`, `or`, `... if ...
    else ...`, `+ - * /`, `min`, `max` and `sqrt`; the build translates them to C.

    Attributes:
        kind: Its name in files, and that of its C file and functions.
        meaning: What it is, in a few words.
        source: Where the equations come from.
        parameters: Its numbers, in the C core's order.
        command: What drives it; None for a passive one.
        states: What it remembers, in order.
        rules: What must hold between its parameters, in order.
        at_start: What its tension follows from at the start, of u (command), l (length), v (rate).
        damped: A condition on parameters under which its tension follows the rate; empty: always.
        at_once: A condition under which its states follow the command at once; empty: never. A
            law without states always does.
        stretches: Whether it stretches all along its path, so that friction in bends holds stretch.
        pushes: Whether its tension may be negative.
        sags: Whether it hangs by its weight between two points, which it pulls down.
        has_drum: Whether a pulley at its base can bear on its drum.
        presets: Published sets of parameters, by name.
    """

    kind: str
    meaning: str
    source: str
    parameters: tuple[Parameter, ...] = ()
    command: Command | None = None
    states: tuple[LawState, ...] = ()
    rules: tuple[Term | Rule, ...] = ()
    at_start: str = "ulv"
    damped: str = ""
    at_once: str = ""
    stretches: bool = False
    pushes: bool = False
    sags: bool = False
    has_drum: bool = False
    presets: Mapping[str, tuple[tuple[str, float], ...]] = {}

    @property
    def terms(self) -> tuple[Term, ...]:
        """The terms among the rules."""
        return tuple(step for step in self.rules if isinstance(step, Term))

    @property
    def conditions(self) -> tuple[Rule, ...]:
        """The rules without the terms."""
        return tuple(step for step in self.rules if isinstance(step, Rule))

    def broken_rule(self, values: Mapping[str, float]) -> str | None:
        """What is wrong with parameters that are within their bounds: the first rule broken.

        Args:
            values: All parameters.
        """
        known = dict(values)
        try:
            for step in self.rules:
                if isinstance(step, Term):
                    known[step.name] = evaluated(step.formula, known)
                elif not evaluated(step.condition, known):
                    named = (f"{name} = {known[name]!r}" for name in names_in(step.condition))
                    return f"{step.text}; here {', '.join(named)}"
        except (ArithmeticError, ValueError):
            return "parameters are so small or large that their quotients are no numbers"
        return None


def evaluated(formula: str, values: Mapping[str, float]) -> float:
    """Return the value of a formula of a law, or whether a condition holds."""
    value: float = eval(_compiled(formula), dict(_FUNCTIONS), dict(values))
    return value


_FUNCTIONS = {"__builtins__": {}, "min": min, "max": max, "sqrt": math.sqrt}


@cache
def _compiled(formula: str) -> CodeType:
    return compile(formula, formula, "eval")


def names_in(formula: str) -> list[str]:
    """Return the parameters and terms in a formula, in order."""
    nodes = [
        node for node in ast.walk(ast.parse(formula, mode="eval")) if isinstance(node, ast.Name)
    ]
    nodes.sort(key=lambda node: node.col_offset)
    return list(dict.fromkeys(node.id for node in nodes if node.id not in _FUNCTIONS))


def positive(name: str, unit: str, default: float | None, meaning: str) -> Parameter:
    """Above zero."""
    return Parameter(name, unit, default, 0.0, math.inf, meaning, open_low=True)


def natural(name: str, unit: str, default: float | None, meaning: str) -> Parameter:
    """Zero or above."""
    return Parameter(name, unit, default, 0.0, math.inf, meaning)


def bounded(name: str, unit: str, default: float | None, low: float, meaning: str) -> Parameter:
    """From `low` to what no winch and no cable has."""
    return Parameter(name, unit, default, low, MAX_VALUE, meaning)


def part(name: str, default: float, meaning: str) -> Parameter:
    """From 0 to 1."""
    return Parameter(name, "1", default, 0.0, 1.0, meaning)


def free(name: str, unit: str, default: float | None, meaning: str) -> Parameter:
    """Any finite number."""
    return Parameter(name, unit, default, -math.inf, math.inf, meaning)
