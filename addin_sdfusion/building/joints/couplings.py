"""Conversion of the couplings of a design to couplings of the robot's coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...robot.finding import Finding, Subject
from ...robot.finding_builders import finite, unknown, warning
from ...robot.model.function import linear
from ...robot.model.joint import Coordinate, Joint, Term
from ...snapshot import CouplingSnapshot, bare_name


def add_couplings(
    joints: Sequence[Joint], couplings: Sequence[CouplingSnapshot]
) -> tuple[tuple[Joint, ...], list[Finding]]:
    """Return the joints with their couplings, and warnings on couplings that are not exported.

    The coordinate of a follower is ratio · leader + offset.
    """
    names = {c.name for joint in joints for c in joint.coordinates}
    terms: dict[str, Term] = {}
    findings = []
    for c in sorted(couplings, key=repr):
        follower, leader = (
            coupled_name(c.follower, c.follower_role),
            coupled_name(c.leader, c.leader_role),
        )
        problem = _problem(c, follower, leader, names, terms)
        if problem:
            subject = Subject("coordinate", follower)
            findings.append(warning(subject, "coupling-left-out", f"its coupling {problem}"))
        else:
            terms[follower] = Term(leader, linear(c.ratio, c.offset))

    def coupled(c: Coordinate) -> Coordinate:
        return replace(c, coupling=(terms[c.name],)) if c.name in terms else c

    return tuple(joint.map_coordinates(coupled) for joint in joints), findings


def coupled_name(joint: str, role: str) -> str:
    """Return the name of a coordinate in the form of `coordinate_name`."""
    name = bare_name(joint)
    return f"{name}_{role}" if role else name


def _problem(
    c: CouplingSnapshot, follower: str, leader: str, names: set[str], terms: dict[str, Term]
) -> str:
    """Return the reason why a coupling cannot be exported, or an empty string."""
    for name in (follower, leader):
        if name not in names:
            return f"is not exported: {unknown('coordinate', name, sorted(names))}"
    if follower in terms:
        return "to a second coordinate is not exported; keep only one coupling"
    at: str | None = leader
    while at is not None:
        if at == follower:
            return "is not exported: the couplings form a cycle, so the coordinate follows itself"
        at = terms[at].coordinate if at in terms else None
    if not finite((c.ratio, c.offset)) or c.ratio == 0.0:
        return f"is not exported: its ratio is {c.ratio:g} and its offset {c.offset:g}"
    return ""
