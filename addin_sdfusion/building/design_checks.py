"""Findings on a design: bodies outside links, ambiguous points, names, kinds."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping

from ..muscles.point_names import parse_point_name
from ..muscles.table import MuscleTable
from ..robot.finding import Finding, Subject
from ..robot.finding_builders import error, listed, warning
from ..robot.model.robot import Inertia, Robot
from ..snapshot import LINK_PREFIX, ROOT, DesignSnapshot, PointSnapshot
from .links.links import Links, in_name_order

_HIGHER = 2.0  # minimum ratio of the extents of the links along y and z that suggests y is up


def snapshot_findings(snapshot: DesignSnapshot) -> list[Finding]:
    """Return an error for every occurrence whose path or parent is invalid."""
    paths = {o.path for o in snapshot.occurrences}
    counts = Counter(o.path for o in snapshot.occurrences)
    bad = {path for path, count in counts.items() if count > 1 or path == ROOT}
    for o in snapshot.occurrences:
        if o.parent != ROOT and not (o.parent in paths and o.path.startswith(f"{o.parent}+")):
            bad.add(o.path)
    problem = "its path is a duplicate or not below its parent; read the design again"
    return [error(Subject("occurrence", path), "bad-occurrence", problem) for path in sorted(bad)]


def body_findings(snapshot: DesignSnapshot, links: Links) -> Iterator[Finding]:
    """Yield findings on bodies outside links, hidden bodies and invalid opacities."""
    for body in snapshot.bodies:
        if not 0.0 <= body.opacity <= 1.0:
            name = f"{body.occurrence}/{body.name}" if body.occurrence else body.name
            problem = f"its opacity must be from 0 to 1, not {body.opacity:g}"
            yield error(Subject("body", name), "bad-opacity", problem)
    outside = {b.occurrence for b in snapshot.bodies if b.occurrence not in links.of_occurrence}
    for path in sorted(outside):
        names = sorted(body.name for body in snapshot.bodies if body.occurrence == path)
        where = "the root component" if path == ROOT else "it"
        target = (
            f"a rigid group {LINK_PREFIX}<link>"
            if links.from_groups
            else "a component that is a link"
        )
        problem = f"bodies {listed(names)} of {where} are not exported; move them into {target}"
        subject = Subject("occurrence", path) if path else Subject("design", snapshot.name)
        yield warning(subject, "body-in-no-link", problem)
    hidden: dict[str, list[str]] = {}
    for body in snapshot.bodies:
        if not body.visible and body.kind == "solid" and body.occurrence in links.of_occurrence:
            hidden.setdefault(links.of_occurrence[body.occurrence], []).append(body.name)
    for link in in_name_order(hidden):
        problem = (
            "has hidden bodies, which are included in its mass but not in its meshes: "
            f"{listed(sorted(hidden[link]))}; show or delete them"
        )
        yield warning(Subject("link", link), "hidden-body", problem)


def massless_links(names: Iterable[str], parts: Mapping[str, Inertia]) -> list[Finding]:
    """Return a warning for every link without mass."""
    problem = "has no mass: it has no solid body with a material; add one to its component or group"
    return [
        warning(Subject("link", name), "link-without-mass", problem)
        for name in names
        if parts[name].mass == 0.0
    ]


def point_findings(snapshot: DesignSnapshot, table: MuscleTable) -> Iterator[Finding]:
    """Yield findings on points that are broken or ignored."""
    used = {row.entity for row in (*table.points, *table.others)}
    for name in in_name_order({p.name for p in snapshot.points if p.problem and p.entity in used}):
        first = min(p.problem for p in snapshot.points if p.name == name and p.problem)
        problem = f"Fusion reports: {first.strip()}; edit it so that it has its former position"
        yield warning(Subject("point", name), "broken-point", problem)
    names = in_name_order({p.name for p in snapshot.points if _is_com(p)})
    if names:
        problem = (
            "centre-of-mass points are ignored, since Fusion computes centres of mass; delete "
            f"{listed(names)}"
        )
        yield warning(Subject("point", names[0]), "com-point-ignored", problem)


def _is_com(point: PointSnapshot) -> bool:
    parsed = parse_point_name(point.name)
    return parsed is not None and parsed.role == "com" and point.use is None


def name_findings(robot: Robot) -> Iterator[Finding]:
    """Yield findings on a missing robot name and on names that clash in files."""
    links = {link.name for link in robot.links}
    if not robot.name:
        problem = "has no name; enter one in Export"
        yield error(Subject("robot", ""), "missing-name", problem)
    for name in in_name_order(links & {joint.name for joint in robot.joints}):
        problem = f"link {name!r} has the same name, which SDF does not allow; rename one of them"
        yield error(Subject("joint", name), "name-clash", problem)
    for kind, names in (
        ("link", links),
        ("joint", {joint.name for joint in robot.joints}),
        ("muscle", {muscle.name for muscle in robot.muscles}),
    ):
        alike: dict[str, list[str]] = {}
        for name in in_name_order(names):
            alike.setdefault(name.casefold(), []).append(name)
        for same in alike.values():
            if len(same) > 1:
                problem = f"differs from {listed(same[1:])} only in upper and lower case; rename it"
                yield warning(Subject(kind, same[0]), "names-differ-by-case", problem)


def design_notes(snapshot: DesignSnapshot, robot: Robot | None) -> Iterator[Finding]:
    """Yield findings on the type of the design: part or assembly."""
    subject = Subject("design", snapshot.name)
    if snapshot.intent == "part" and robot is not None and not robot.coordinates:
        problem = "is a part design, so nothing moves; create a hybrid or assembly design"
        yield warning(subject, "part-design", problem)
    if snapshot.intent == "assembly" and robot is not None and not robot.muscles:
        problem = (
            "is an assembly design, which cannot contain points; open the component that a muscle "
            "passes and create its via points there"
        )
        yield warning(subject, "assembly-design", problem)


def up_hint(snapshot: DesignSnapshot, parts: Mapping[str, Inertia], base: str) -> Iterator[Finding]:
    """Yield a warning if the links suggest that the y axis points up."""
    if snapshot.settings.up_axis != "z" or base not in parts:
        return
    weighing = [part.com for part in parts.values() if part.mass > 0.0]
    if len(weighing) < 2 or parts[base].mass == 0.0:
        return
    across = [max(com[i] for com in weighing) - min(com[i] for com in weighing) for i in (1, 2)]
    is_lowest = parts[base].com[1] <= min(com[1] for com in weighing)
    if is_lowest and across[0] > _HIGHER * across[1]:
        problem = (
            "the z axis is used as the up axis, but all links are above the base along y; if y "
            "points up in this design, choose it in Export"
        )
        yield warning(Subject("design", snapshot.name), "up-axis", problem)
