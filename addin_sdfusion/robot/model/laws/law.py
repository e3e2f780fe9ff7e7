"""Definition of a muscle law: parameters, rules between them, command, states and dependencies.

This module uses only the standard library, since hatch_build.py imports it to build the package.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Mapping
from functools import cache
from types import CodeType
from typing import NamedTuple

MAX_VALUE = 1e9
"""Maximum parameter of winches and heavy cables in SI units, for which the core is accurate."""


class Parameter(NamedTuple):
    """A parameter of a muscle law.

    Attributes:
        name: Name in files.
        unit: Unit in FMI notation.
        default: Default value, or None for a required parameter.
        low: Minimum value.
        high: Maximum value.
        meaning: Description in a few words.
        open_low: Whether the value must be greater than `low`.
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
        """Bounds as text, such as `above 0 and at most 1`."""
        if math.isinf(self.low):
            return "finite" if math.isinf(self.high) else f"at most {self.high:g}"
        lower = f"above {self.low:g}" if self.open_low else f"at least {self.low:g}"
        return lower if math.isinf(self.high) else f"{lower} and at most {self.high:g}"

    def allows(self, value: float) -> bool:
        """Return whether a value is finite and within the bounds."""
        above = self.low < value if self.open_low else self.low <= value
        return math.isfinite(value) and above and value <= self.high


class Command(NamedTuple):
    """The command of a muscle.

    Attributes:
        name: Name, such as `force` or `excitation`.
        unit: Unit in FMI notation.
        low: Minimum: a number, or a formula of parameters.
        high: Maximum: a number, or a formula of parameters.
    """

    name: str
    unit: str
    low: float | str
    high: float | str


class LawState(NamedTuple):
    """A state variable of a muscle.

    Attributes:
        name: Name; with the muscle's name it forms a variable, such as `activation.biceps`.
        unit: Unit in FMI notation.
        where: Condition on parameters for the state to exist; empty for a state that always exists.
            Conditional states come last.
        at_start: Variables that determine the initial value: u (command), l (length), v (rate).
        low, high: Range of the state: numbers, or formulas of parameters; infinite if unlimited.
    """

    name: str
    unit: str
    where: str = ""
    at_start: str = "ulv"
    low: float | str = -math.inf
    high: float | str = math.inf


class Term(NamedTuple):
    """A value computed from parameters, for use in the subsequent rules.

    Attributes:
        name: Name in formulas; in C it is also the function `<law>_<name>(p)`.
        formula: Formula of parameters and preceding terms.
    """

    name: str
    formula: str


class Rule(NamedTuple):
    """A condition on several parameters. Each parameter is already within its bounds.

    Attributes:
        condition: Condition on parameters and preceding terms, such as `rest_low <= rest_high`.
        why: Explanation, if the condition is not self-explanatory.
    """

    condition: str
    why: str = ""

    @property
    def text(self) -> str:
        """Error message for a muscle that violates the rule."""
        return f"{self.condition} must hold" + (f": {self.why}" if self.why else "")


class MuscleLawDefinition(NamedTuple):
    """Definition of a muscle law: the tension as a function of command, length and rate.

    Conditions and formulas use Python syntax with comparisons, `and`, `or`, `... if ... else ...`,
    `+ - * /`, `min`, `max` and `sqrt`. The build translates them to C.

    Attributes:
        kind: Name in files, also of its C file and functions.
        meaning: Description in a few words.
        source: Equations or their reference.
        parameters: Parameters, in the C core's order.
        command: Command, or None for a passive law.
        states: State variables, in order.
        rules: Terms and conditions on the parameters, in order.
        at_start: Variables that determine the initial tension: u (command), l (length), v (rate).
        damped: Condition on parameters for the tension to depend on the rate; empty: always.
        at_once: Condition for the states to follow the command without delay; empty: never. The
            tension of a law without states always follows the command without delay.
        stretches: Whether the muscle stretches along its whole path, so that friction at its bends
            affects the stretch.
        pushes: Whether the tension can be negative.
        sags: Whether the cable sags by its weight between two points and pulls them down.
        has_drum: Whether the inertia of a pulley at the base can be added to a drum.
        presets: Published parameter sets, by name.
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
        """Return the error text for the first violated rule, or None.

        Args:
            values: All parameters, within their bounds.
        """
        scope = dict(values)
        try:
            for step in self.rules:
                if isinstance(step, Term):
                    scope[step.name] = evaluate(step.formula, scope)
                elif not evaluate(step.condition, scope):
                    named = (f"{name} = {scope[name]!r}" for name in formula_names(step.condition))
                    return f"{step.text}; here {', '.join(named)}"
        except (ArithmeticError, ValueError):
            return "parameters are too small or too large: a quotient is not finite"
        return None


def evaluate(formula: str, values: Mapping[str, float]) -> float:
    """Return the value of a formula, or whether a condition is true."""
    value: float = eval(_compiled(formula), dict(_FUNCTIONS), dict(values))
    return value


_FUNCTIONS = {"__builtins__": {}, "min": min, "max": max, "sqrt": math.sqrt}


@cache
def _compiled(formula: str) -> CodeType:
    return compile(formula, formula, "eval")


def formula_names(formula: str) -> list[str]:
    """Return the names of the parameters and terms in a formula, in order."""
    nodes = [
        node for node in ast.walk(ast.parse(formula, mode="eval")) if isinstance(node, ast.Name)
    ]
    nodes.sort(key=lambda node: node.col_offset)
    return list(dict.fromkeys(node.id for node in nodes if node.id not in _FUNCTIONS))


def positive(name: str, unit: str, default: float | None, meaning: str) -> Parameter:
    """Return a parameter that must be positive."""
    return Parameter(name, unit, default, 0.0, math.inf, meaning, open_low=True)


def non_negative(name: str, unit: str, default: float | None, meaning: str) -> Parameter:
    """Return a parameter that must not be negative."""
    return Parameter(name, unit, default, 0.0, math.inf, meaning)


def bounded(name: str, unit: str, default: float | None, low: float, meaning: str) -> Parameter:
    """Return a parameter from `low` to `MAX_VALUE`."""
    return Parameter(name, unit, default, low, MAX_VALUE, meaning)


def fraction(name: str, default: float, meaning: str) -> Parameter:
    """Return a parameter from 0 to 1."""
    return Parameter(name, "1", default, 0.0, 1.0, meaning)


def unbounded(name: str, unit: str, default: float | None, meaning: str) -> Parameter:
    """Return a parameter that can be any finite number."""
    return Parameter(name, unit, default, -math.inf, math.inf, meaning)
