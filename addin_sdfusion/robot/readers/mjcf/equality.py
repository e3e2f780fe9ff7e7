"""Equalities of MJCF: those of joints, as exact couplings; see `loops` for those of bodies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from ...finding_builders import unknown
from ...formats.reading.xml import Node
from ...model.function import Polynomial, taylor
from ...model.joint import Coordinate, Joint, Term
from .compiler import numbers
from .document import MAIN, Document

CONNECT, WELD = "connect", "weld"
"""The equalities of bodies."""
DEFAULT = (0.0, 1.0, 0.0, 0.0, 0.0)


def with_equalities(joints: Sequence[Joint], document: Document) -> list[Joint]:
    """The joints with the coordinates that equalities make follow others, or hold."""
    known = {c.name: c for joint in joints for c in joint.coordinates}
    coupled: list[Node] = []
    for node in document.parts("equality"):
        node = document.with_defaults(node, MAIN, "equality")
        if node.attribute("active", "true") == "false":
            continue
        if node.tag in (CONNECT, WELD):
            continue  # they close loops
        if node.tag != "joint":
            name = node.attribute("name", "")
            problem = (
                f"equality <{node.tag}> {name!r} is not supported: what it holds is free here, and "
                "the robot moves otherwise"
            )
            node.warning("equality-left-out", problem)
        elif _couple(node, known):
            coupled.append(node)
    note_exact(coupled, "joints")
    return [
        replace(joint, coordinates=tuple(known[c.name] for c in joint.coordinates))
        for joint in joints
    ]


def note_exact(nodes: Sequence[Node], what: str) -> None:
    """Note equalities that give way in MuJoCo."""
    if nodes:
        problem = (
            f"{len(nodes)} equalities of {what} hold exactly here; those of MuJoCo are springs "
            "with a time constant, which give way"
        )
        nodes[0].warning("exact-equality", problem)


def _couple(node: Node, known: dict[str, Coordinate]) -> bool:
    """Couple joint1 to joint2, or hold it; whether that was done."""
    first, second = node.attribute("joint1"), node.attribute("joint2", "")
    for name in (first, second) if second else (first,):
        if name not in known:
            node.error("unknown-coordinate", unknown("joint of one coordinate", name, list(known)))
            return False
    c = known[first]
    if c.coupling or c.locked:
        problem = f"{first!r} follows another joint, or is held, already; left out"
        node.warning("equality-left-out", problem)
        return False
    given = numbers(node, "polycoef")[: len(DEFAULT)]
    values = (*given, *DEFAULT[len(given) :]) if given else DEFAULT
    if not second:
        known[first] = replace(c, locked=True, initial=c.initial + values[0])
        return True
    powers = _shifted(values, known[second].initial)
    function = Polynomial((powers[0] + c.initial, *powers[1:]))
    open_ = replace(c, lower=-math.inf, upper=math.inf, actuated=False)
    known[first] = replace(open_, coupling=(Term(second, function),))
    return True


def _shifted(c: Sequence[float], by: float) -> list[float]:
    """The coefficients of the sum of c_k (x - by)^k, in powers of x; zeros at the end left out."""
    powers = list(taylor(c, -by))
    while len(powers) > 1 and powers[-1] == 0.0:
        powers.pop()
    return powers
