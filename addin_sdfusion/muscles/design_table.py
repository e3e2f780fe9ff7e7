"""Table of a design's muscles, task points, markers and wrap surfaces.

Attributes take precedence over names. Positions are in the design's root frame, at the design's
pose, in [m].
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Protocol, TypeVar

from ..robot.errors import InputError
from ..robot.finding import Finding
from ..snapshot import DesignSnapshot, PointSnapshot, SurfaceSnapshot
from .attributes import MUSCLES, POINT, WRAP, PointAttribute, read_muscles, read_point, read_wrap
from .checks import finding, table_findings
from .point_names import is_point_name, natural_key, parse_point_name
from .rows import COLORS, MarkerRow, MuscleRow, MuscleTable, TaskRow, ViaPointRow, WrapRow


class _Located(Protocol):
    @property
    def entity(self) -> str: ...
    @property
    def occurrence(self) -> str: ...


Located = TypeVar("Located", bound=_Located)
Row = TypeVar("Row", TaskRow, MarkerRow, WrapRow)
NamedPoint = TypeVar("NamedPoint", TaskRow, MarkerRow)


def read_table(
    snapshot: DesignSnapshot, link_of: Mapping[str, str] | None = None
) -> tuple[MuscleTable, list[Finding]]:
    """The table of a design.

    Args:
        snapshot: The design.
        link_of: The link of each occurrence's path. With it, a point whose component is in several
            places is taken where its own link is.

    Returns:
        The table, and what is wrong with the design's attributes and names.
    """
    findings: list[Finding] = []
    points: list[ViaPointRow] = []
    tasks: list[TaskRow] = []
    markers: list[MarkerRow] = []
    read = [(point, _point(point, findings)) for point in _once(snapshot.points, findings)]
    for point, attribute in _one_each([(p, a) for p, a in read if a], link_of or {}):
        if attribute.role == "via":
            points.append(_via_point(point, attribute))
        elif attribute.role == "task":
            task = _named_point(TaskRow, point, attribute)
            tasks.append(replace(task, axes=attribute.axes) if attribute.axes else task)
        else:
            markers.append(_named_point(MarkerRow, point, attribute))
    rows = _rows(snapshot, points, findings)
    order = {row.name: i for i, row in enumerate(rows)}
    points.sort(key=lambda p: (order[p.muscle], p.number, natural_key(p.name), p.occurrence))
    table = MuscleTable(
        rows,
        tuple(points),
        tuple(sorted(tasks, key=_by_name)),
        tuple(sorted(markers, key=_by_name)),
        tuple(sorted(_wraps(snapshot, link_of or {}, findings), key=_by_name)),
    )
    return table, [*findings, *table_findings(table)]


def _by_name(row: Row) -> Any:
    return natural_key(row.name), row.occurrence


def _once(points: Iterable[PointSnapshot], findings: list[Finding]) -> list[PointSnapshot]:
    """The points but those that only look like one of the add-in."""
    good = []
    for point in sorted(points, key=lambda p: (natural_key(p.name), p.entity, p.occurrence)):
        name = parse_point_name(point.name)
        if POINT in point.attributes or (name and name.role != "com"):
            good.append(point)
        elif name is None and is_point_name(point.name):
            message = (
                f"the construction point {point.name!r} is not read: its name is not "
                "VP_motor<number>_EXPORT_<link>_<number>; pick it in Define muscles or rename it"
            )
            findings.append(finding("warning", "bad-point-name", message, "point", point.name))
    return good


def _point(point: PointSnapshot, findings: list[Finding]) -> PointAttribute | None:
    """The attribute of a point, or what its name holds in its place."""
    text = point.attributes.get(POINT)
    if text is not None:
        try:
            return read_point(text)
        except InputError as error:
            message = f"what is stored on the construction point {point.name!r} cannot be read"
            message += f" ({error}); pick it again in Define muscles"
            findings.append(finding("error", "bad-attribute", message, "point", point.name))
    name = parse_point_name(point.name)
    if name is None or name.role == "com":
        return None
    if name.role == "via":
        if name.copy:
            message = (
                f"the construction point {point.name!r} has the name of another one; delete it, or "
                f"put it in its place in Define muscles ({name.muscle})"
            )
            findings.append(finding("error", "copied-point", message, "point", point.name))
        return PointAttribute("via", name.link, name.muscle, name.number)
    suffix = f"_{name.copy}" if name.copy else ""
    return PointAttribute(name.role, name.link, name=name.link + suffix)


def _one_each(
    read: Sequence[tuple[PointSnapshot, PointAttribute]], link_of: Mapping[str, str]
) -> list[tuple[PointSnapshot, PointAttribute]]:
    """Each point once: where it is meant, if its component is in several places."""
    groups: dict[str, list[PointSnapshot]] = {}
    for i, (point, _) in enumerate(read):
        groups.setdefault(point.entity or f"#{i}", []).append(point)
    attributes = {id(point): attribute for point, attribute in read}
    chosen = []
    for group in groups.values():
        first = attributes[id(group[0])]
        point = _meant(group, first.occurrence, first.link, link_of)
        chosen.append((point, attributes[id(point)]))
    return chosen


def _meant(
    candidates: Sequence[Located], occurrence: str, link: str, link_of: Mapping[str, str]
) -> Located:
    """The place that is meant: as stored, else of the same link, else the first."""
    tests: tuple[Callable[[Located], bool], ...] = (
        lambda p: bool(occurrence) and p.occurrence == occurrence,
        lambda p: link_of.get(p.occurrence) == link,
    )
    for test in tests:
        for candidate in candidates:
            if test(candidate):
                return candidate
    return min(candidates, key=lambda p: natural_key(p.occurrence))


def _via_point(point: PointSnapshot, a: PointAttribute) -> ViaPointRow:
    source = point.entity, point.occurrence, point.name
    return ViaPointRow(a.muscle, a.number, a.link, point.position, *source, a.made)


def _named_point(kind: type[NamedPoint], point: PointSnapshot, a: PointAttribute) -> NamedPoint:
    source = point.entity, point.occurrence, a.made
    return kind(a.name or point.name, a.link, point.position, *source)


def _rows(
    snapshot: DesignSnapshot, points: Sequence[ViaPointRow], findings: list[Finding]
) -> tuple[MuscleRow, ...]:
    """The muscles that the design lists, then those that only have points."""
    try:
        listed = read_muscles(snapshot.attributes.get(MUSCLES, "[]"))
    except InputError as error:
        message = f"the design's list of muscles cannot be read ({error}); open Define muscles, "
        message += "set the force limits and press OK"
        findings.append(finding("error", "bad-attribute", message, "design", snapshot.name))
        listed = ()
    rows = {row.name: row for row in reversed(listed)}
    for name, count in Counter(row.name for row in listed).items():
        if count > 1:
            message = f"muscle {name!r} is listed {count} times; the first counts"
            findings.append(finding("warning", "duplicate-muscle", message, "muscle", name))
    ordered = [rows[name] for name in dict.fromkeys(row.name for row in listed)]
    unlisted = {point.muscle for point in points} - rows.keys()
    for name in sorted(unlisted, key=natural_key):
        row = MuscleRow(name, COLORS[len(ordered) % len(COLORS)])
        ordered.append(row)
        message = (
            f"muscle {name!r} has no force limits: {row.f_min:g} to {row.f_max:g} N are used; "
            "set them in Define muscles"
        )
        findings.append(finding("warning", "default-forces", message, "muscle", name))
    return tuple(ordered)


def _wraps(
    snapshot: DesignSnapshot, link_of: Mapping[str, str], findings: list[Finding]
) -> list[WrapRow]:
    groups: dict[str, list[SurfaceSnapshot]] = {}
    for i, surface in enumerate(snapshot.surfaces):
        if WRAP in surface.attributes:
            groups.setdefault(surface.entity or f"#{i}", []).append(surface)
    rows = []
    for group in groups.values():
        try:
            attribute = read_wrap(group[0].attributes[WRAP])
        except InputError as error:
            where = group[0].occurrence or snapshot.name
            message = f"what is stored on a wrap face of {where!r} cannot be read ({error}); "
            message += "pick the face again in Define muscles"
            findings.append(finding("error", "bad-attribute", message, "occurrence", where))
            continue
        face = _meant(group, attribute.occurrence, attribute.link, link_of)
        shape = face.shape, face.radius, face.centre, face.axis, face.length
        place = face.entity, face.occurrence
        rows.append(WrapRow(attribute.name, attribute.link, *shape, attribute.muscles, *place))
    return rows
