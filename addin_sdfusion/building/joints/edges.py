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
from .checks import doubts, mistakes

_OUTSIDE = object()


@dataclass(frozen=True)
class Edge:
    """A joint between two links.

    Attributes:
        name: Its name, as the robot has it.
        one, two: The links; None for the world. `one` moves relative to `two`.
        motions: In their order from `two` to `one`; none if it is rigid.
        origin_one, origin_two: Where it is, in [m]; None if it does not matter.
        symmetric: Whether it is no joint, but something else that keeps the two together, so that
            neither is the child.
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
        """Whether the two do not move against each other."""
        return not self.motions

    @property
    def links(self) -> tuple[str, ...]:
        """Its links without the world."""
        return tuple(end for end in (self.one, self.two) if end is not None)

    def other(self, link: str) -> str | None:
        """What is on its other side."""
        return self.two if self.one == link else self.one


class Edges(NamedTuple):
    """What connects the links of a design.

    Attributes:
        joints: Joints, and rigid groups across links, by name.
        held: Links that are grounded to the component of another link, where nothing else says.
        findings: What is wrong with them.
    """

    joints: tuple[Edge, ...]
    held: tuple[Edge, ...]
    findings: tuple[Finding, ...]


def find_edges(snapshot: DesignSnapshot, links: Links) -> Edges:
    """What connects the links of a design."""
    findings: list[Finding] = []
    edges = [*_from_joints(snapshot, links, findings), *_from_groups(snapshot, links)]
    cut = {bare_name(name) for name in snapshot.settings.cut_joints}
    for name in in_name_order(cut):
        subject = Subject("joint", name)
        if any(edge.name == name for edge in edges):
            problem = "is left out, as chosen in Export, so that the robot is a tree"
            findings.append(warning(subject, "cut-joint", problem))
        elif not any(bare_name(joint.name) == name for joint in snapshot.joints):
            names = in_name_order({bare_name(joint.name) for joint in snapshot.joints})
            problem = f"is to be cut: {unknown('joint', name, names)}; choose again in Export"
            findings.append(warning(subject, "unknown-cut-joint", problem))
    kept = sorted((edge for edge in edges if edge.name not in cut), key=edge_key)
    return Edges(tuple(kept), tuple(_held(snapshot, links)), tuple(findings))


def edge_key(edge: Edge) -> tuple[object, ...]:
    """Orders edges by name, and those of one name by all that they say."""
    rest = repr((edge.origin_one, edge.origin_two, edge.motions))
    return natural_key(edge.name), edge.name, edge.one or "", edge.two or "", rest


def grounded_links(snapshot: DesignSnapshot, links: Links) -> tuple[str, ...]:
    """Links that are fixed to the root: grounded all the way up, or the root's own bodies."""
    of = links.of_occurrence
    return in_name_order({of[path] for path in (ROOT, *grounded_paths(snapshot)) if path in of})


def pinned_links(snapshot: DesignSnapshot, links: Links) -> set[str]:
    """Those of them that the user has fixed, not perhaps the CAD system by itself."""
    pinned = {o.path for o in snapshot.occurrences if o.grounded} & grounded_paths(snapshot)
    of = links.of_occurrence
    return {of[path] for path in (ROOT, *pinned) if path in of}


def grounded_paths(snapshot: DesignSnapshot) -> set[str]:
    """Occurrences that are grounded, and whatever holds them as well, up to the root."""
    grounded = {ROOT}
    for o in sorted(snapshot.occurrences, key=lambda o: len(o.path)):  # what holds others first
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
            findings += _within(subject, joint, ends[0])
            continue
        if _OUTSIDE in ends and None not in (joint.one, joint.two):
            findings.append(_outside(subject, joint, links, ends[0] is _OUTSIDE))
            continue
        if name in {bare_name(cut) for cut in snapshot.settings.cut_joints}:
            yield Edge(name, one, two)
            continue
        wrong = mistakes(subject, joint)
        findings += wrong or doubts(subject, joint)
        if not wrong:
            motions = () if joint.kind == "rigid" else joint.motions
            origins = joint.origin_one, joint.origin_two
            unit = tuple(replace(m, axis=normalized(m.axis)) for m in motions)
            yield Edge(name, one, two, unit, *origins)


def _link_at(path: str | None, links: Links, grounded: Collection[str]) -> object:
    """Return the link of an occurrence; None for the world, `_OUTSIDE` if there is none.

    What is grounded and no link is as good as the world.
    """
    if path is None:
        return _OUTSIDE
    return links.of_occurrence.get(path, None if path in grounded else _OUTSIDE)


def _within(subject: Subject, joint: JointSnapshot, link: object) -> Iterator[Finding]:
    if joint.kind == "rigid":
        return
    problem = (
        f"is inside link {link!r} and not exported, so it does not move; make its parts links of "
        "their own, or the joint rigid"
    )
    yield warning(subject, "joint-within-link", problem)


def _outside(subject: Subject, joint: JointSnapshot, links: Links, one: bool) -> Finding:
    path = joint.one if one else joint.two
    what = f"in no rigid group {LINK_PREFIX}<link>" if links.from_groups else "in no link"
    problem = f"is left out: component {path!r} is {what}; put it into the link that it moves with"
    return warning(subject, "joint-outside-links", problem)


def _from_groups(snapshot: DesignSnapshot, links: Links) -> Iterator[Edge]:
    """Rigid groups that are not links keep those of their members together."""
    for group in snapshot.groups:
        if group.suppressed or (links.from_groups and is_link_group(group)):
            continue
        of = links.of_occurrence
        first, *others = in_name_order({of[p] for p in group.occurrences if p in of}) or ("",)
        name = bare_name(group.name)
        for link in others:
            called = name if len(others) == 1 else f"{name}_{link}"
            yield Edge(called, link, first, symmetric=True)


def _held(snapshot: DesignSnapshot, links: Links) -> list[Edge]:
    of: Mapping[str, str] = links.of_occurrence
    pairs = {
        (of[o.path], of[o.parent])
        for o in snapshot.occurrences
        if o.is_fixed and o.path in of and o.parent in of and of[o.path] != of[o.parent]
    }
    edges = [Edge(f"{above}_{link}", link, above, symmetric=True) for link, above in pairs]
    return sorted(edges, key=edge_key)
