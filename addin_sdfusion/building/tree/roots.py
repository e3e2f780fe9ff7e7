"""Roots of the trees of a robot: the base and other links that are fixed to the world."""

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
    """Roots of the trees.

    Attributes:
        links: Root of each tree, the base first. Trees that are not connected to the base are
            included, although they are an error, so that they are checked too.
        floating: The base, if it floats; otherwise empty.
    """

    links: tuple[str, ...]
    floating: str
    findings: tuple[Finding, ...]


def find_roots(
    groups: Sequence[Sequence[str]],
    between: Sequence[Edge],
    world: Sequence[Edge],
    grounded: Sequence[str],
    bodies: DisjointSets,
    settings: ExportSettings,
    design: str,
) -> Roots:
    """Return the roots of the trees.

    The base is the chosen link. If no link is chosen, it is the link that is grounded or has a
    joint to the root component; further movable joints to it close loops. If no such link exists,
    it is the only link that is not a child.

    Args:
        groups: Groups of connected links, in order.
        between: Connections between the links.
        world: Joints to the root component.
        grounded: Links that are fixed to the root component.
        bodies: Sets of rigidly connected links.
        settings: The chosen base, and whether it floats.
    """
    findings: list[Finding] = []
    subject = Subject("design", design)
    connected = in_name_order({*grounded, *(edge.links[0] for edge in world)})
    fixed = {*grounded, *(edge.links[0] for edge in world if edge.is_rigid)}
    roots: dict[int, str] = {}
    for k, group in enumerate(groups):
        candidates = [link for link in connected if link in group]
        if settings.base in group:
            roots[k] = settings.base
            findings += _ignored_grounds(candidates, grounded, bodies, settings)
        elif candidates:
            firm = [link for link in candidates if link in fixed]
            firsts = list({bodies.find(link): link for link in reversed(firm)}.values())
            roots[k] = next((link for link in candidates if link in grounded), candidates[0])
            if len(firsts) > 1:
                problem = (
                    f"links {listed(in_name_order(firsts))} of one tree are fixed to the world"
                )
                findings.append(_several_bases_error(subject, problem))
    if not roots:
        return _ungrounded_roots(groups, between, settings, subject)
    loose = [group for k, group in enumerate(groups) if k not in roots]
    findings += [_unconnected_error(group) for group in loose]
    base = next((r for r in roots.values() if r == settings.base), "")
    if not base and not settings.fixed_base and len(roots) > 1:
        problem = f"links {listed(in_name_order(roots.values()))} are fixed to the world"
        findings.append(
            _several_bases_error(subject, f"{problem} in separate trees, but the base must float")
        )
    ordered = sorted(in_name_order(roots.values()), key=lambda link: link != base)
    floating = "" if settings.fixed_base else ordered[0]
    ordered += [_first_root(group, between) for group in loose]
    return Roots(tuple(ordered), floating, tuple(findings))


def _ungrounded_roots(
    groups: Sequence[Sequence[str]],
    between: Sequence[Edge],
    settings: ExportSettings,
    subject: Subject,
) -> Roots:
    """Return the roots of a robot without links that are fixed to the world."""
    candidates = in_name_order(
        link for group in groups for link in _non_child_links(group, between)
    )
    findings = []
    if not candidates:
        problem = "no link is grounded, and every link is the child of a joint: no base is found"
        advice = "; ground its component, or choose the base in Export"
        findings.append(error(subject, "no-base", problem + advice))
    elif len(candidates) > 1:
        problem = f"no link is grounded, and links {listed(candidates)} are not children of a joint"
        findings.append(_several_bases_error(subject, problem))
    roots = tuple(_first_root(group, between) for group in groups)
    return Roots(roots, "" if settings.fixed_base else roots[0], tuple(findings))


def _first_root(group: Sequence[str], between: Sequence[Edge]) -> str:
    return in_name_order(_non_child_links(group, between) or group)[0]


def _non_child_links(group: Sequence[str], between: Sequence[Edge]) -> list[str]:
    """Return the links of a group that are not children of a joint.

    Only the first of several rigidly connected links is returned.
    """
    together = DisjointSets(group)
    inside = [edge for edge in between if edge.links[0] in group]
    for edge in inside:
        if edge.symmetric:
            together.join(*edge.links)
    children = {together.find(edge.one) for edge in inside if not edge.symmetric and edge.one}
    firsts = {together.find(link): link for link in reversed(group)}
    return [link for body, link in firsts.items() if body not in children]


def _ignored_grounds(
    candidates: Sequence[str],
    grounded: Sequence[str],
    bodies: DisjointSets,
    settings: ExportSettings,
) -> list[Finding]:
    """Return a warning for every grounded link that is not part of the chosen base."""
    others = [
        link
        for link in candidates
        if link in grounded and bodies.find(link) != bodies.find(settings.base)
    ]
    problem = (
        f"is grounded but exported as movable, because the base is {settings.base!r}; unground it"
    )
    return [warning(Subject("link", link), "ground-ignored", problem) for link in others]


def _several_bases_error(subject: Subject, problem: str) -> Finding:
    message = f"{problem}; ground only one and connect the others, or choose the base in Export"
    return error(subject, "several-bases", message)


def _unconnected_error(group: Sequence[str]) -> Finding:
    one = len(group) == 1
    subject = Subject("link", group[0])
    which = "no joint connects it" if one else f"no joint connects it, and {listed(group[1:])},"
    advice = "; add a joint or a rigid group, or ground its component"
    return error(subject, "link-not-connected", f"{which} to the base{advice}")
