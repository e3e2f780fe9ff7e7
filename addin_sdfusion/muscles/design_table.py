"""Reader for the muscle table of a design: muscles, task points, markers and wrap surfaces.

The stored use of a point takes precedence over its name. Positions are in the root frame of the
design, at the pose of the design, in [m].
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, replace
from typing import Protocol, TypeVar

from ..robot.finding import Finding
from ..robot.finding_builders import listed
from ..robot.model.robot import POSITIONS, WORLD
from ..snapshot import (
    COPY,
    DesignSnapshot,
    MuscleSnapshot,
    PointSnapshot,
    PointUse,
    SurfaceSnapshot,
    SurfaceUse,
)
from .checks import finding, table_findings
from .point_names import is_point_name, natural_key, parse_point_name
from .rows import PointRow, WrapRow, by_name
from .table import COLORS, MuscleTable


class _Located(Protocol):
    @property
    def entity(self) -> str: ...
    @property
    def occurrence(self) -> str: ...
    @property
    def lost(self) -> str: ...


Located = TypeVar("Located", bound=_Located)

_SEVERAL = "its component has several occurrences"


def read_table(
    snapshot: DesignSnapshot, link_of: Mapping[str, str] | None = None
) -> tuple[MuscleTable, list[Finding]]:
    """Return the muscle table of a design.

    Args:
        link_of: Link of each occurrence, by path. It selects the occurrence of a point without
            a stored occurrence whose component has several occurrences.
    """
    findings: list[Finding] = []
    link_of = link_of or {}
    read = [(point, _use(point, findings)) for point in _valid_points(snapshot.points, findings)]
    used = _unique_points([(point, use) for point, use in read if use], link_of, findings)
    points = [_point_row(point, use, link_of) for point, use in used]
    via = [point for point in points if point.role == "via"]
    rows = _rows(snapshot, {point.muscle for point in via}, findings)
    order = {row.name: i for i, row in enumerate(rows)}
    table = MuscleTable(
        rows,
        tuple(sorted(via, key=lambda p: (order[p.muscle], p.number))),
        by_name(point for point in points if point.role != "via"),
        tuple(
            sorted(
                _wraps(snapshot, link_of, findings),
                key=lambda w: (natural_key(w.name), w.occurrence),
            )
        ),
    )
    return table, [*findings, *table_findings(table)]


def _valid_points(points: Iterable[PointSnapshot], findings: list[Finding]) -> list[PointSnapshot]:
    """Return the points that belong to the add-in by their use or by a valid name."""
    good = []
    for point in sorted(points, key=lambda p: (natural_key(p.name), p.entity, p.occurrence)):
        name = parse_point_name(point.name)
        if point.use is not None or (name and name.role != "com"):
            good.append(point)
        elif name is None and is_point_name(point.name):
            message = (
                f"the construction point {point.name!r} is not read: its name is not "
                "VP_motor<number>_EXPORT_<link>_<number>; pick it in Define muscles or rename it"
            )
            findings.append(finding("warning", "bad-point-name", message, "point", point.name))
    return good


def _use(point: PointSnapshot, findings: list[Finding]) -> PointUse | None:
    """Return the stored use of a point, or the use specified by its name."""
    if point.use is not None:
        return point.use
    name = parse_point_name(point.name)
    if name is None or name.role == "com":
        return None
    if name.role == "via":
        if name.copy:
            message = (
                f"the construction point {point.name!r} has the name of another point; delete it, "
                f"or insert it into muscle {name.muscle!r} in Define muscles"
            )
            findings.append(finding("error", "copied-point", message, "point", point.name))
        return PointUse("via", name.link, name.muscle, name.number)
    suffix = f"_{name.copy}" if name.copy else ""
    return PointUse(name.role, name.link, name=name.link + suffix)


def _unique_points(
    read: Sequence[tuple[PointSnapshot, PointUse]],
    link_of: Mapping[str, str],
    findings: list[Finding],
) -> list[tuple[PointSnapshot, PointUse]]:
    """Return each point once, in the occurrence that it belongs to."""
    groups: dict[str, list[tuple[PointSnapshot, PointUse]]] = {}
    for i, (point, use) in enumerate(read):
        groups.setdefault(point.entity or f"#{i}", []).append((point, use))
    chosen = []
    for group in groups.values():
        subject = ("point", group[0][0].name)
        point, lost = _select_occurrence(group, link_of, subject, findings)
        use = next(use for other, use in group if other is point)
        chosen.append((replace(point, lost=lost), use))
    return _without_copies(chosen, findings)


def _select_occurrence(
    group: Sequence[tuple[Located, PointUse | SurfaceUse]],
    link_of: Mapping[str, str],
    subject: tuple[str, str],
    findings: list[Finding],
) -> tuple[Located, str]:
    """Return the occurrence that a point or face belongs to, and the reason if it is unknown.

    It is the stored occurrence or the only one. Otherwise it is the only one on the link.
    """
    present = [(item, use) for item, use in group if not item.lost]
    stored = [item for item, use in present if use.occurrence and use.occurrence == item.occurrence]
    if len(stored) == 1:
        return stored[0], ""
    if len(group) == 1 or not present:
        return group[0][0], group[0][0].lost
    link = present[0][1].link
    on_link = [
        item for item, use in present if use.link and link_of.get(item.occurrence) == use.link
    ]
    if len(on_link) == 1:
        return on_link[0], ""
    where = listed(sorted(item.occurrence for item, _ in group))
    reason = f"{_SEVERAL}, {where}, and it is unclear which one "
    reason += f"belongs to link {link!r}" if link else "it belongs to"
    kind = subject[0].replace("_", " ")
    message = f"{kind} {subject[1]!r}: {reason}; pick it again in Define muscles"
    findings.append(finding("error", "ambiguous-point", message, *subject))
    return group[0][0], reason


def _without_copies(
    points: Sequence[tuple[PointSnapshot, PointUse]], findings: list[Finding]
) -> list[tuple[PointSnapshot, PointUse]]:
    """Return the points without copies of other points; report lost points."""

    def key(use: PointUse) -> tuple[str, str, int, str]:
        return use.role, use.muscle, use.number, use.name

    keys = {key(use) for point, use in points if not point.lost.startswith(COPY)}
    originals = []
    for point, use in points:
        if point.lost.startswith(COPY) and key(use) in keys:
            message = (
                f"construction point {point.name!r} of {point.occurrence!r} is not used: "
                f"{point.lost}; delete it, or pick it in Define muscles"
            )
            findings.append(finding("warning", "copied-point", message, "point", point.name))
            continue
        originals.append((point, use))
        if point.lost and not point.lost.startswith(_SEVERAL):
            label = f"point {use.number} of muscle {use.muscle!r}" if use.muscle else point.name
            message = (
                f"{label} is not found: {point.lost}. It is kept; repair the design, or pick the "
                "point again and delete the old one in Define muscles"
            )
            findings.append(finding("error", "lost-point", message, "point", point.name))
    return originals


def _link_at(item: Located, link_of: Mapping[str, str]) -> str:
    """Return the link of a point or face, or the path of its occurrence if it has no link."""
    return link_of.get(item.occurrence, item.occurrence or WORLD)


def _point_row(point: PointSnapshot, use: PointUse, link_of: Mapping[str, str]) -> PointRow:
    row = PointRow(
        **{f.name: getattr(use, f.name) for f in fields(use)},
        position=point.position,
        entity=point.entity,
    )
    axes = use.axes or POSITIONS if use.role == "task" else ()
    name = "" if use.role == "via" else use.name or point.name
    link = use.link or ("" if point.lost else _link_at(point, link_of))
    row = replace(row, lost=point.lost)
    if point.lost:
        return replace(row, name=name, link=link, axes=axes)
    return replace(row, name=name, link=link, axes=axes, occurrence=point.occurrence)


def _rows(
    snapshot: DesignSnapshot, used: set[str], findings: list[Finding]
) -> tuple[MuscleSnapshot, ...]:
    """Return the muscles that the design lists, then muscles that are defined only by points."""
    listed = [replace(muscle, color=muscle.color.lower()) for muscle in snapshot.muscles]
    rows = {row.name: row for row in reversed(listed)}
    for name, count in Counter(row.name for row in listed).items():
        if count > 1:
            message = f"muscle {name!r} is listed {count} times; the first entry is used"
            findings.append(finding("warning", "duplicate-muscle", message, "muscle", name))
    ordered = [rows[name] for name in dict.fromkeys(row.name for row in listed)]
    for name in sorted(used - rows.keys(), key=natural_key):
        row = MuscleSnapshot(name, COLORS[len(ordered) % len(COLORS)])
        ordered.append(row)
        message = (
            f"muscle {name!r} has no force limits: {row.f_min:g} to {row.f_max:g} N are used; "
            "set them in Define muscles"
        )
        findings.append(finding("warning", "default-forces", message, "muscle", name))
    return tuple(ordered)


def _wraps(
    snapshot: DesignSnapshot, link_of: Mapping[str, str], findings: list[Finding]
) -> Iterable[WrapRow]:
    groups: dict[str, list[tuple[SurfaceSnapshot, SurfaceUse]]] = {}
    for i, surface in enumerate(snapshot.surfaces):
        if surface.use is not None:
            groups.setdefault(surface.entity or f"#{i}", []).append((surface, surface.use))
    for group in groups.values():
        subject = ("wrap_surface", group[0][1].name)
        face, lost = _select_occurrence(group, link_of, subject, findings)
        use = next(use for other, use in group if other is face)
        if lost.startswith(COPY):
            message = f"wrap surface {use.name!r} of {face.occurrence!r} is not used: {lost}"
            findings.append(finding("warning", "copied-face", message, *subject))
            continue
        if lost and not lost.startswith(_SEVERAL):
            message = f"wrap surface {use.name!r} is not found: {lost}. It is kept"
            findings.append(finding("error", "lost-face", message, *subject))
        face = replace(face, lost=lost)
        link = use.link or ("" if lost else _link_at(face, link_of))
        yield WrapRow(
            name=use.name,
            link=link,
            muscles=use.muscles,
            occurrence=use.occurrence if lost else face.occurrence,
            face=face,
        )
