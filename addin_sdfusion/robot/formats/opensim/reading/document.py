"""The document of an .osim file: its version, its sets of objects, what they name.

Files of version 4 only: in older ones joints are inside of bodies. OpenSim itself writes element
names that are no XML, `HuntCrossleyForce::ContactParametersSet`; they are mended before parsing.
"""

from __future__ import annotations

import re
from pathlib import Path

from ....errors import InputError
from ....finding import Subject
from ...reading.xml import TRUE, Node, Notes, parse

OLDEST = 40000
_COLONS = re.compile(rb"<(/?\w+)::(\w+)")


def read_document(file: Path, notes: Notes) -> Node:
    """Return the `<Model>` of a file.

    Raises:
        InputError: It is not readable XML, not OpenSim's, or too old.
    """
    root = parse(file, Subject("robot", file.stem), notes, mend=_without_colons)
    if root.tag != "OpenSimDocument":
        raise InputError(f"<{root.tag}> is not <OpenSimDocument>", file=file, line=root.line)
    version = root.attribute("Version", "0")
    if not version.isascii() or not version.isdigit() or int(version[:9]) < OLDEST:
        what = (
            f"is of OpenSim's format {version[:20]!r}, in which joints are inside of bodies; open "
            f"it in OpenSim 4 and save it there, which writes format {OLDEST} or newer"
        )
        raise InputError(what, file=file, line=root.line)
    models = root.all("Model", "ModelComponentSet")
    if len(models) != 1 or models[0].tag != "Model":
        what = f"holds {len(root.all('Model'))} models, not one"
        raise InputError(what, file=file, line=root.line)
    model = models[0]
    return model.about(Subject("robot", model.attribute("name", "") or file.stem))


def _without_colons(data: bytes) -> bytes:
    return _COLONS.sub(rb"<\1__\2", data)


def objects(parent: Node, tag: str) -> list[Node]:
    """Return the objects of a set, such as `<BodySet><objects>`."""
    return [
        child
        for group in parent.all(tag)
        for inner in group.all("objects")
        for child in inner.all()
    ]


def is_true(node: Node, tag: str, default: bool) -> bool:
    """Return the value of a switch."""
    child = node.optional(tag)
    return default if child is None else child.text.lower() in TRUE


def text(node: Node, tag: str, default: str = "") -> str:
    """Return the text of a child element; the default if there is none."""
    child = node.optional(tag)
    return default if child is None else child.text


def inner(node: Node, tag: str) -> Node | None:
    """Return the one element inside a child, such as the function in `<x_location>`."""
    child = node.optional(tag)
    found = [] if child is None else child.all()
    return found[0] if found else None


def last_name(path: str) -> str:
    """Return the name of what a path leads to."""
    return path.rpartition("/")[2]
