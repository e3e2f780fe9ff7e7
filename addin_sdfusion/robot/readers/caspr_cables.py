"""Reads CASPR's cable sets."""

from __future__ import annotations

from collections.abc import Sequence

from ..errors import UnknownNameError
from ..finding import Subject, member
from ..model import WORLD, Link
from ..muscle import CableSet, Muscle, ViaPoint
from ..placement import Vector3
from ..pose import add
from .caspr_links import link_by_number
from .xml import Node, shortened


def read_cables(
    root: Node, links: Sequence[Link], chosen: str | None
) -> tuple[tuple[CableSet, ...], str]:
    """The cable sets of a file and the name of the active one.

    A set that holds anything but ideal cables is left out with a warning; if it is the active one,
    that is an error.

    Args:
        root: The root of the file.
        links: The robot's links, by number.
        chosen: The set to make active; the file's default if None.

    Raises:
        UnknownNameError: There is no set of the chosen name.
    """
    if root.tag != "cables":
        root.error("not-caspr", f"<{root.tag}> is not CASPR's <cables>")
        return (), ""
    nodes = [
        node.about(Subject("cable_set", node.attribute("id"))) for node in root.all("cable_set")
    ]
    active = _active(root, [node.subject.name for node in nodes], chosen)
    cable_sets = []
    for node in nodes:
        unsupported = _unsupported(node)
        if unsupported is None:
            cable_sets.append(_cable_set(node, links, active))
        elif node.subject.name == active:
            unsupported.error("unsupported-cable", _names_element(unsupported))
            cable_sets.append(CableSet(active, ()))
        else:
            problem = f"{_names_element(unsupported)}; the whole set is left out"
            unsupported.warning("unsupported-cable", problem)
    return tuple(cable_sets), active


def _names_element(node: Node) -> str:
    return f"<{node.tag}> is not supported"


def _active(root: Node, names: list[str], chosen: str | None) -> str:
    if chosen is not None:
        if chosen not in names:
            raise UnknownNameError("cable set", chosen, names, file=root.file)
        return chosen
    default = root.attribute("default_cable_set", "")
    if not default and names:
        problem = f"no default_cable_set; the first one, {names[0]!r}, is used"
        root.warning("no-default-cable-set", problem)
        return names[0]
    if default and default not in names:
        what = UnknownNameError("cable set", default, names).what
        root.error("unknown-cable-set", f"default_cable_set: {what}")
    return default


def _unsupported(cable_set: Node) -> Node | None:
    """The first cable or attachment that is not an ideal one; it speaks for the set."""
    for cable in cable_set.all():
        if cable.tag != "cable_ideal":
            return cable
        for attachments in cable.all("attachments"):
            for attachment in attachments.all():
                if attachment.tag != "attachment":
                    return attachment
    return None


def _cable_set(node: Node, links: Sequence[Link], active: str) -> CableSet:
    name = node.subject.name
    muscles = []
    for cable in node.all():
        subject = member("muscle", cable.attribute("name"), name, active)
        muscles.append(_muscle(cable.about(subject), links))
    return CableSet(name, tuple(muscles))


def _muscle(node: Node, links: Sequence[Link]) -> Muscle:
    reference = node.attribute("attachment_reference")
    if node.has("attachment_reference") and reference not in ("com", "joint"):
        problem = f"attachment_reference {shortened(reference)} is neither 'com' nor 'joint'"
        node.error("bad-reference", problem)
    attachments = node.required("attachments")
    points = [
        _via_point(attachment, links, reference)
        for attachment in (attachments.all() if attachments else [])
    ]
    properties = node.required("properties")
    f_min = properties.number("force_min") if properties else 0.0
    f_max = properties.number("force_max", infinite=True) if properties else 0.0
    return Muscle(node.attribute("name"), tuple(points), f_min, f_max)


def _via_point(node: Node, links: Sequence[Link], reference: str) -> ViaPoint:
    location = node.vector("location")
    link = link_by_number(node, links)
    if link is None:
        return ViaPoint(WORLD, location)
    return ViaPoint(link.name, _in_link_frame(location, link, reference))


def _in_link_frame(location: Vector3, link: Link, reference: str) -> Vector3:
    return add(link.inertia.com, location) if reference == "com" else location
