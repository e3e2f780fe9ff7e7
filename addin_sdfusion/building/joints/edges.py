"""Edges of a design's graph: joints between two links, or a link and the world."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

from ...muscles.point_names import natural_key
from ...robot.finding import Finding, Subject
from ...robot.finding_builders import unknown, warning
from ...robot.model.pose import Vector3
from ...robot.model.rotations import normalized
from ...snapshot import LINK_PREFIX, ROOT, DesignSnapshot, JointSnapshot, MotionSnapshot, bare_name
from ..links.links import Links, in_name_order, is_link_group
from .checks import joint_errors, joint_warnings

_OUTSIDE = object()


@dataclass(frozen=True)
class Edge:
    """A joint between two links.

    Attributes:
        name: Name of the joint in the robot.
        one, two: The links; None for the world. `one` moves relative to `two`.
        motions: Motions, ordered from `two` to `one`; empty for a rigid joint.
        origin_one, origin_two: Position of the joint, in [m]; None if it is not needed.
        symmetric: Whether the edge is a rigid connection without parent and child, such as a
            rigid group.
    """

    name: str
    one: str | None
    two: str | None
    motions: tuple[MotionSnapshot, ...] = ()
    origin_one: Vector3 | None = None
    origin_two: Vector3 | None = None
    symmetric: bool = False

    @property
    def is_rigid(self) -> bool:
        """Whether the two links cannot move relative to each other."""
        return not self.motions

    @property
    def links(self) -> tuple[str, ...]:
        """The links of the edge without the world."""
        return tuple(end for end in (self.one, self.two) if end is not None)

    def other(self, link: str) -> str | None:
        """Return the link on the other side, or None for the world."""
        return self.two if self.one == link else self.one


class Edges(NamedTuple):
    """Connections between the links of a design.

    Attributes:
        joints: Joints, and rigid groups across links, by name.
        grounding: Connections of links that are grounded to the component of another link. They are
            used only if no other connection exists.
        cut: The joints that the user has chosen to close loops, by name.
    """

    joints: tuple[Edge, ...]
    grounding: tuple[Edge, ...]
    cut: tuple[Edge, ...]
    findings: tuple[Finding, ...]


def find_edges(snapshot: DesignSnapshot, links: Links) -> Edges:
    """Return the connections between the links of a design."""
    findings: list[Finding] = []
    edges = [*_from_joints(snapshot, links, findings), *_from_groups(snapshot, links)]
    chosen = {bare_name(name) for name in snapshot.settings.cut_joints}
    names = {bare_name(joint.name) for joint in snapshot.joints} | {edge.name for edge in edges}
    for name in in_name_order(chosen - names):
        problem = f"cannot be cut: {unknown('joint', name, in_name_order(names))}"
        problem += "; choose again in Export"
        findings.append(warning(Subject("joint", name), "unknown-cut-joint", problem))
    uncut = sorted((edge for edge in edges if edge.name not in chosen), key=edge_key)
    cut = sorted((edge for edge in edges if edge.name in chosen), key=edge_key)
    grounding = _grounded_edges(snapshot, links)
    return Edges(tuple(uncut), tuple(grounding), tuple(cut), tuple(findings))


def edge_key(edge: Edge) -> tuple[object, ...]:
    """Return a sort key: the name of the edge, then its other properties."""
    rest = repr((edge.origin_one, edge.origin_two, edge.motions))
    return natural_key(edge.name), edge.name, edge.one or "", edge.two or "", rest


def grounded_links(snapshot: DesignSnapshot, links: Links) -> tuple[str, ...]:
    """Return the links fixed to the root component.

    Their occurrence and all its ancestors are grounded, or they contain the bodies of the root.
    """
    of = links.of_occurrence
    return in_name_order({of[path] for path in (ROOT, *grounded_paths(snapshot)) if path in of})


def pinned_links(snapshot: DesignSnapshot, links: Links) -> set[str]:
    """Return the grounded links that the user has grounded, not the CAD system."""
    pinned = {o.path for o in snapshot.occurrences if o.grounded} & grounded_paths(snapshot)
    of = links.of_occurrence
    return {of[path] for path in (ROOT, *pinned) if path in of}


def grounded_paths(snapshot: DesignSnapshot) -> set[str]:
    """Return the occurrences that are grounded and have only grounded ancestors."""
    grounded = {ROOT}
    for o in sorted(snapshot.occurrences, key=lambda o: len(o.path)):  # parents first
        if o.is_fixed and o.parent in grounded:
            grounded.add(o.path)
    return grounded - {ROOT}


def _from_joints(snapshot: DesignSnapshot, links: Links, findings: list[Finding]) -> Iterator[Edge]:
    grounded = {ROOT, *grounded_paths(snapshot)}
    for joint in sorted(snapshot.joints, key=lambda j: (natural_key(j.name), j.name, repr(j))):
        name = bare_name(joint.name)
        subject = Subject("joint", name)
        ends = [_link_at(path, links, grounded) for path in (joint.one, joint.two)]
        one, two = (end if isinstance(end, str) else None for end in ends)
        if one is two is None and None not in (joint.one, joint.two):
            continue
        if joint.suppressed:
            problem = "is suppressed in the timeline and not exported; unsuppress or delete it"
            if ends[0] != ends[1]:
                findings.append(warning(subject, "suppressed-joint", problem))
            continue
        if ends[0] == ends[1] and None not in (joint.one, joint.two):
            findings += _joint_within_link(subject, joint, ends[0])
            continue
        if _OUTSIDE in ends and None not in (joint.one, joint.two):
            findings.append(_joint_outside_links(subject, joint, links, ends[0] is _OUTSIDE))
            continue
        wrong = joint_errors(subject, joint)
        if wrong and name in {bare_name(cut) for cut in snapshot.settings.cut_joints}:
            findings.append(_open_cut(subject, wrong[0]))
            continue
        findings += wrong or joint_warnings(subject, joint)
        if not wrong:
            motions = () if joint.kind == "rigid" else joint.motions
            origins = joint.origin_one, joint.origin_two
            unit = tuple(replace(m, axis=normalized(m.axis)) for m in motions)
            yield Edge(name, one, two, unit, *origins)


def _link_at(path: str | None, links: Links, grounded: Collection[str]) -> object:
    """Return the link of an occurrence; None for the world, `_OUTSIDE` if it has no link.

    A grounded occurrence without a link is part of the world.
    """
    if path is None:
        return _OUTSIDE
    return links.of_occurrence.get(path, None if path in grounded else _OUTSIDE)


def _joint_within_link(subject: Subject, joint: JointSnapshot, link: object) -> Iterator[Finding]:
    if joint.kind == "rigid":
        return
    problem = (
        f"is inside link {link!r} and is not exported, so it does not move; make its parts "
        "separate links, or make the joint rigid"
    )
    yield warning(subject, "joint-within-link", problem)


def _joint_outside_links(
    subject: Subject, joint: JointSnapshot, links: Links, one: bool
) -> Finding:
    path = joint.one if one else joint.two
    owner = f"rigid group {LINK_PREFIX}<link>" if links.from_groups else "link"
    problem = (
        f"is not exported: component {path!r} does not belong to a {owner}; move it into the link "
        "that it moves with"
    )
    return warning(subject, "joint-outside-links", problem)


def _open_cut(subject: Subject, wrong: Finding) -> Finding:
    """Return the warning on a joint that is cut and cannot be exported."""
    reason = wrong.message.partition(": ")[2]
    return warning(subject, "cut-joint", f"{reason}. It is cut and not exported: its loop is open")


def _from_groups(snapshot: DesignSnapshot, links: Links) -> Iterator[Edge]:
    """Yield rigid connections between the links that a rigid group connects."""
    for group in snapshot.groups:
        if group.suppressed or (links.from_groups and is_link_group(group)):
            continue
        of = links.of_occurrence
        first, *others = in_name_order({of[p] for p in group.occurrences if p in of}) or ("",)
        name = bare_name(group.name)
        for link in others:
            called = name if len(others) == 1 else f"{name}_{link}"
            yield Edge(called, link, first, symmetric=True)


def _grounded_edges(snapshot: DesignSnapshot, links: Links) -> list[Edge]:
    of: Mapping[str, str] = links.of_occurrence
    pairs = {
        (of[o.path], of[o.parent])
        for o in snapshot.occurrences
        if o.is_fixed and o.path in of and o.parent in of and of[o.path] != of[o.parent]
    }
    edges = [Edge(f"{above}_{link}", link, above, symmetric=True) for link, above in pairs]
    return sorted(edges, key=edge_key)
