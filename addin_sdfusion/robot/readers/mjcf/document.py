"""The document of an MJCF file: what it includes, and its classes of defaults."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ...errors import InputError
from ...finding import Subject
from ...formats.reading.xml import ABSOLUTE, Node, Notes, parse, shortened
from ...limits import DEFAULTS
from ...mesh_files import is_file

MAIN = "main"
MOST_INCLUDED = 100
"""So many files may be included."""
ACTUATORS = (
    "general",
    "motor",
    "position",
    "intvelocity",
    "velocity",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
    "plugin",
)
"""Elements of actuators: in defaults all of them are of one kind."""
_CLOSE = re.compile(rb'(="[^"<>]*")(?=[A-Za-z_])')
_COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)


class Document:
    """A file with what it includes.

    Attributes:
        root: Its `<mujoco>`.
        classes: The elements of defaults of each class, its ancestors' first.
    """

    def __init__(self, file: Path, notes: Notes) -> None:
        self._folder = file.parent
        self._included: set[Path] = {file.resolve()}
        self._read_already: dict[Any, Node] = {}  # by the <include>, which is met several times
        self.root = parse(file, Subject("robot", file.stem), notes, mend=_as_xml)
        if self.root.tag != "mujoco":
            raise InputError(f"<{self.root.tag}> is not <mujoco>", file=file, line=self.root.line)
        name = self.root.attribute("model", "") or file.stem
        self.root = self.root.about(Subject("robot", name))
        self.classes: dict[str, list[Node]] = {MAIN: []}
        for section in self.sections("default"):
            self._add_class(section, section.attribute("class", MAIN), None)

    def children(self, node: Node, *tags: str) -> Iterator[Node]:
        """The children of an element, those of included files in place of `<include>`."""
        for child in node.all():
            if child.tag == "include":
                yield from self.children(self._read(child), *tags)
            elif not tags or child.tag in tags:
                yield child

    def sections(self, tag: str) -> list[Node]:
        """The sections of a kind, which may come several times."""
        return list(self.children(self.root, tag))

    def parts(self, section: str, *tags: str) -> list[Node]:
        """The elements in all sections of a kind."""
        return [part for node in self.sections(section) for part in self.children(node, *tags)]

    def with_defaults(self, node: Node, inherited: str, tag: str | None = None) -> Node:
        """The element with the attributes of its class, where it does not give them itself.

        Args:
            node: The element.
            inherited: The class of what it is in; its own counts more.
            tag: What it is called in defaults, if not as here.
        """
        given = node.element.attrib
        for attributes in self.defaults(node, inherited, (tag or node.tag,)):
            for name, value in attributes.element.attrib.items():
                if name != "class" and name not in given:
                    node.element.set(name, value)
        return node

    def defaults(self, node: Node, inherited: str, tags: tuple[str, ...]) -> list[Node]:
        """The elements of defaults that count for an element, the most particular first."""
        name = node.attribute("class", inherited or MAIN)
        if name not in self.classes:
            node.error("unknown-class", f"there is no default class {name!r}")
            name = MAIN
        return [part for part in reversed(self.classes[name]) if part.tag in tags]

    def _add_class(self, node: Node, name: str, parent: str | None) -> None:
        before = [] if parent is None else self.classes[parent]
        own = self.classes.setdefault(name, list(before))
        inner = []
        for child in self.children(node):
            if child.tag == "default":
                inner.append(child)
            else:
                own.append(child)
        if len(own) > DEFAULTS:
            problem = f"class {shortened(name)} has more than {DEFAULTS} elements of defaults"
            raise InputError(problem, file=node.file, line=node.line)
        for child in inner:
            self._add_class(child, child.attribute("class"), name)

    def _read(self, include: Node) -> Node:
        """The root of an included file."""
        if include.element not in self._read_already:
            self._read_already[include.element] = self._read_new(include)
        return self._read_already[include.element]

    def _read_new(self, include: Node) -> Node:
        name = include.attribute("file")
        file = self._folder / name  # or, as in MuJoCo, beside the file that includes it
        if not is_file(file) and is_file(include.file.parent / name):
            file = include.file.parent / name
        note_absolute(include, name)
        place = file.resolve()
        if place in self._included or len(self._included) > MOST_INCLUDED:
            include.error("included-twice", f"{name!r} is included already, or too many files are")
            return Node(
                include.element.makeelement("none"), include.file, include.subject, include.notes
            )
        self._included.add(place)
        return parse(file, include.subject, include.notes, mend=_as_xml)


def note_absolute(node: Node, name: str) -> None:
    """Warn of a file of the robot that is named by a path of this machine."""
    if Path(name.removeprefix("file://")).is_absolute():
        problem = (
            f"{shortened(name)} is a path on this machine alone: what is written of the robot "
            "could not be read elsewhere; name it by its path from the folder of this file"
        )
        node.warning(ABSOLUTE, problem)


def _as_xml(data: bytes) -> bytes:
    """Without comments, in which MuJoCo takes `--`, and with spaces between attributes."""
    parts = _COMMENT.split(data)
    comments = [*(b"\n" * comment.count(b"\n") for comment in _COMMENT.findall(data)), b""]
    return b"".join(
        _CLOSE.sub(rb"\1 ", part) + lines for part, lines in zip(parts, comments, strict=True)
    )
