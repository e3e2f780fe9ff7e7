"""Findings on elements that no reader uses, so that the loss of data is always reported."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

from lxml import etree

from .xml import Node, Notes

CODE = "unread-element"
"""Code of the findings."""
MAX_NAMES = 10
"""Number of elements that a finding lists by name."""


def note_unread(notes: Notes, ignored: Collection[str]) -> None:
    """Report elements that were not used, one warning for each kind of element.

    An element below an unused one is not listed.

    Args:
        notes: Findings of the reader, with the used elements; warnings are added to them.
        ignored: Tags without influence on the robot's motion, such as colours.
    """
    for root in notes.roots:
        kinds: dict[str, list[Node]] = {}
        for node in _unused(root, ignored):
            kinds.setdefault(_place(node), []).append(node)
        for place, nodes in kinds.items():
            nodes[0].warning(CODE, f"{place} is not supported and was ignored{_count(nodes)}")


def _place(node: Node) -> str:
    """Return an element with the element that contains it, such as `<ForceSet><Bushing>`."""
    above = node.element.getparent()
    while above is not None and above.tag == "objects":
        above = above.getparent()
    return f"<{node.tag}>" if above is None else f"<{above.tag}><{node.tag}>"


def _count(nodes: Sequence[Node]) -> str:
    names = [repr(name) for node in nodes if (name := node.element.get("name"))]
    listed = f": {', '.join(names[:MAX_NAMES])}" if names else ""
    return f" ({len(nodes)} times{listed})" if len(nodes) > 1 or names else ""


def _unused(root: Node, ignored: Collection[str]) -> Iterator[Node]:
    pending = [root.element]
    while pending:
        element = pending.pop()
        if not isinstance(element.tag, str) or etree.QName(element).localname in ignored:
            continue
        if element not in root.notes.used and not _is_container(element):
            yield Node(element, root.file, root.subject, root.notes)
        else:
            pending += reversed(element)


def _is_container(element: etree._Element) -> bool:
    """Return whether an element only groups objects, such as OpenSim's `<ControllerSet>`."""
    return element.tag == "objects" or str(element.tag).endswith("Set")
