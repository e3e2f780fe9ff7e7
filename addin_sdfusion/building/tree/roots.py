"""Roots of a robot's trees: the base, and all else that is fixed to the ground."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ...robot.finding import Finding, Subject
from ...robot.finding_builders import error, listed, warning
from ...settings import ExportSettings
from ..joints.edges import Edge
from ..links.links import in_name_order
from .disjoint_sets import DisjointSets


class Roots(NamedTuple):
    """Where the trees start.

    Attributes:
        links: The root of each tree, the base first. Also of those that nothing connects to the
            base, which is an error: so all else about them is found as well.
        floating: The base, if it floats; else empty.
        findings: What is wrong.
    """

    links: tuple[str, ...]
    floating: str
    findings: tuple[Finding, ...]


def find_roots(
    parts: Sequence[Sequence[str]],
    between: Sequence[Edge],
    world: Sequence[Edge],
    grounded: Sequence[str],
    bodies: DisjointSets,
    settings: ExportSettings,
    design: str,
) -> Roots:
    """Find where the trees start.

    The base is the chosen link; else the one that is grounded or jointed to the root; else, where
    there is no such link, the only one that is never a child.

    Args:
        parts: Links that are connected, in order.
        between: What connects them.
        world: Joints to the root.
        grounded: Links that are fixed to the root.
        bodies: Links that are rigidly connected.
        settings: Which base was chosen, and whether it floats.
        design: Name of the design.
    """
    findings: list[Finding] = []
    subject = Subject("design", design)
    held = in_name_order({*grounded, *(edge.links[0] for edge in world)})
    roots: dict[int, str] = {}
    for k, part in enumerate(parts):
        candidates = [link for link in held if link in part]
        if settings.base in part:
            roots[k] = settings.base
            findings += _not_grounded(candidates, grounded, bodies, settings)
        elif candidates:
            firsts = list({bodies.find(link): link for link in reversed(candidates)}.values())
            roots[k] = next((link for link in candidates if link in grounded), candidates[0])
            if len(firsts) > 1:
                what = f"links {listed(in_name_order(firsts))} of one tree are held to the ground"
                findings.append(_several(subject, what))
    if not roots:
        return _nothing_held(parts, between, settings, subject)
    loose = [part for k, part in enumerate(parts) if k not in roots]
    findings += [_loose_part(part) for part in loose]
    base = next((r for r in roots.values() if r == settings.base), "")
    if not base and not settings.fixed_base and len(roots) > 1:
        what = f"links {listed(in_name_order(roots.values()))} are held to the ground"
        findings.append(_several(subject, f"{what} in separate trees, and the base is to float"))
    ordered = sorted(in_name_order(roots.values()), key=lambda link: link != base)
    floating = "" if settings.fixed_base else ordered[0]
    ordered += [_first(part, between) for part in loose]
    return Roots(tuple(ordered), floating, tuple(findings))


def _nothing_held(
    parts: Sequence[Sequence[str]],
    between: Sequence[Edge],
    settings: ExportSettings,
    subject: Subject,
) -> Roots:
    """Return the base where nothing is held to the ground."""
    candidates = in_name_order(link for part in parts for link in _never_a_child(part, between))
    findings = []
    if not candidates:
        problem = "nothing is grounded, and every link is moved by some joint: no base is found"
        advice = "; ground its component, or choose the base in Export"
        findings.append(error(subject, "no-base", problem + advice))
    elif len(candidates) > 1:
        problem = f"nothing is grounded, and links {listed(candidates)} are moved by no joint"
        findings.append(_several(subject, problem))
    roots = tuple(_first(part, between) for part in parts)
    return Roots(roots, "" if settings.fixed_base else roots[0], tuple(findings))


def _first(part: Sequence[str], between: Sequence[Edge]) -> str:
    return in_name_order(_never_a_child(part, between) or part)[0]


def _never_a_child(part: Sequence[str], between: Sequence[Edge]) -> list[str]:
    """The links of a part that no joint moves; of those held together by no joint the first."""
    together = DisjointSets(part)
    inside = [edge for edge in between if edge.links[0] in part]
    for edge in inside:
        if edge.symmetric:
            together.join(*edge.links)
    children = {together.find(edge.one) for edge in inside if not edge.symmetric and edge.one}
    firsts = {together.find(link): link for link in reversed(part)}
    return [link for body, link in firsts.items() if body not in children]


def _not_grounded(
    candidates: Sequence[str],
    grounded: Sequence[str],
    bodies: DisjointSets,
    settings: ExportSettings,
) -> list[Finding]:
    """Return the base was chosen: that others are grounded does not count."""
    others = [
        link
        for link in candidates
        if link in grounded and bodies.find(link) != bodies.find(settings.base)
    ]
    problem = f"is grounded, but exported as movable, as the base is {settings.base!r}; unground it"
    return [warning(Subject("link", link), "ground-ignored", problem) for link in others]


def _several(subject: Subject, what: str) -> Finding:
    problem = f"{what}; ground one only and connect the others, or choose the base in Export"
    return error(subject, "several-bases", problem)


def _loose_part(part: Sequence[str]) -> Finding:
    one = len(part) == 1
    subject = Subject("link", part[0])
    which = "no joint connects it" if one else f"no joint connects it, and {listed(part[1:])},"
    advice = "; add a joint or a rigid group, or ground its component"
    return error(subject, "link-not-connected", f"{which} to the base{advice}")
