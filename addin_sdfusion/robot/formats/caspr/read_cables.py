"""Reader of the cable sets of CASPR."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from ...caspr_vocabulary import CASPR_CABLES, CASPR_PULLEYS, Property
from ...errors import UnknownNameError
from ...finding import member
from ...model.muscle import BasePulley, CableModel, CableSet, Muscle, ViaPoint
from ...model.robot import WORLD, Link
from ...model.rotations import add
from ..reading.unique_names import with_unique_names
from ..reading.xml import Node, short_repr
from .read_links import link_by_number

FORCES = ("force_min", "force_max")


def read_cables(
    root: Node, links: Sequence[Link], chosen: str | None
) -> tuple[tuple[CableSet, ...], str]:
    """Return the cable sets of a file and the name of the active set.

    A set with an unknown kind of cable or attachment is omitted with a warning. If it is the active
    set, this is an error.
    """
    if root.tag != "cables":
        root.error("not-caspr", f"<{root.tag}> is not CASPR's <cables>")
        return (), ""
    nodes = [node.named("cable_set", "id") for node in root.all("cable_set")]
    active = _active(root, [node.subject.name for node in nodes], chosen)
    cable_sets = []
    for node in nodes:
        unsupported = _unsupported(node)
        if unsupported is None:
            cable_sets.append(_cable_set(node, links, active))
        elif node.subject.name == active:
            others = [other.subject.name for other in nodes if _unsupported(other) is None]
            problem = _unsupported_message(unsupported)
            if others:
                problem += f"; choose another cable set: {', '.join(map(repr, others))}"
            unsupported.error("unsupported-cable", problem)
            cable_sets.append(CableSet(active, ()))
        else:
            problem = f"{_unsupported_message(unsupported)}; the whole set is omitted"
            unsupported.warning("unsupported-cable", problem)
    return tuple(cable_sets), active


def _unsupported_message(node: Node) -> str:
    choices = ", ".join([*CASPR_CABLES, "attachment", *CASPR_PULLEYS])
    return f"<{node.tag}> is not supported (known: {choices})"


def _active(root: Node, names: list[str], chosen: str | None) -> str:
    if chosen is not None:
        if chosen not in names:
            raise UnknownNameError("cable set", chosen, names, file=root.file)
        return chosen
    default = root.attribute("default_cable_set", "")
    if not default and names:
        problem = f"has no default_cable_set; the first set, {names[0]!r}, is used"
        root.warning("no-default-cable-set", problem)
        return names[0]
    if default and default not in names:
        problem = UnknownNameError("cable set", default, names).problem
        root.error("unknown-cable-set", f"default_cable_set: {problem}")
    return default


def _unsupported(cable_set: Node) -> Node | None:
    """Return the first cable or attachment of an unknown kind, or None."""
    for cable in cable_set.all():
        if cable.tag not in CASPR_CABLES:
            return cable
        for attachments in cable.all("attachments"):
            for attachment in attachments.all():
                if attachment.tag != "attachment" and attachment.tag not in CASPR_PULLEYS:
                    return attachment
    return None


def _cable_set(node: Node, links: Sequence[Link], active: str) -> CableSet:
    name = node.subject.name
    muscles = []
    for cable in with_unique_names(node.all(), partial(member, "muscle", of=name, active=active)):
        subject = member("muscle", cable.attribute("name"), name, active)
        muscles.append(_muscle(cable.with_subject(subject), links))
    return CableSet(name, tuple(muscles))


def _muscle(node: Node, links: Sequence[Link]) -> Muscle:
    points, pulley = _path(node, links)
    properties = node.required("properties")
    name = node.attribute("name")
    if properties is None:
        return Muscle(name, points, 0.0, 0.0, pulley=pulley)
    model = _model(node.tag, properties)
    if model.kind == "passive_spring":
        return Muscle(name, points, 0.0, 0.0, model, pulley)
    f_min = properties.number("force_min")
    f_max = properties.number("force_max", infinite=True)
    return Muscle(name, points, f_min, f_max, model, pulley)


def _model(tag: str, properties: Node) -> CableModel:
    """Return the muscle law from the properties of a cable."""
    cable = CASPR_CABLES[tag]
    forces = () if cable.kind == "passive_spring" else FORCES
    tags = [*forces, *(item.tag for item in cable.properties)]
    for child in properties.all():
        if child.tag not in tags:
            problem = f"<{child.tag}> is not a property of <{tag}>; ignored"
            child.warning("unknown-property", problem, tags)
    parameters = [
        (item.name(k), value)
        for item in cable.properties
        for k, value in enumerate(_values(properties, item), start=1)
    ]
    return CableModel(cable.kind, tuple(parameters))


def _values(parent: Node, item: Property) -> tuple[float, ...]:
    """Return the numbers of a property; empty if it does not exist."""
    node = parent.required(item.tag) if item.required else parent.optional(item.tag)
    if node is None:
        return ()
    return node.numbers(item.size or max(1, len(node.text.split())))


def _path(cable: Node, links: Sequence[Link]) -> tuple[tuple[ViaPoint, ...], BasePulley | None]:
    """Return the via points of a cable, and the pulley at the first one or None."""
    reference = cable.attribute("attachment_reference")
    if cable.has("attachment_reference") and reference not in ("com", "joint"):
        problem = f"attachment_reference {short_repr(reference)} must be 'com' or 'joint'"
        cable.error("bad-reference", problem)
    group = cable.required("attachments")
    points: list[ViaPoint] = []
    pulley = None
    for node in group.all() if group else []:
        if node.tag not in CASPR_PULLEYS:
            points.append(_via_point(node, links, reference))
            continue
        if points:
            problem = (
                f"<{node.tag}> is attachment {len(points) + 1}; a pulley must be the first one"
            )
            node.error("misplaced-pulley", problem)
        point, pulley = _pulley(node)
        points.append(point)
    return tuple(points), pulley


def _pulley(node: Node) -> tuple[ViaPoint, BasePulley]:
    words = CASPR_PULLEYS[node.tag]
    point = ViaPoint(WORLD, node.vector(words.location))
    parameters = [(item.tag, _values(node, item)) for item in words.properties]
    return point, BasePulley(words.kind, tuple(parameters))


def _via_point(node: Node, links: Sequence[Link], reference: str) -> ViaPoint:
    location = node.vector("location")
    link = link_by_number(node, links)
    if link is None:
        return ViaPoint(WORLD, location)
    at_com = reference == "com"
    return ViaPoint(link.name, add(link.inertia.com, location) if at_com else location)
