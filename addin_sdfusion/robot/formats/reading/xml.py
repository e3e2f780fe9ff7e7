"""Safe XML parsing of untrusted files, with errors that contain file and line."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import cast

from lxml import etree

from ...errors import InputError
from ...files import read_file
from ...finding import Finding, Severity, Subject
from ...finding_builders import label
from ...limits import XML, XML_ELEMENTS, xml_fault
from ...model.pose import Vector3
from .encoding import to_utf8

ZERO: Vector3 = (0.0, 0.0, 0.0)
ENTITIES = "uses XML entities, which are not allowed here; write the text in full"
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
INFINITY = re.compile(r"([+-]?)inf(inity)?", re.ASCII | re.IGNORECASE)
SPACE = re.compile(r"\s")
INTEGER = re.compile(r"\d{1,9}", re.ASCII)
TRUE = ("true", "1")


ABSOLUTE = "absolute-path"
"""Code of findings on absolute paths, which experiments reject."""


@dataclass
class Notes:
    """Findings and locations that a reader collects.

    Attributes:
        locations: File and line of each object.
        files: Files that were read.
        elements: Total number of XML elements in these files.
        roots: Root elements of the files whose unread elements are reported.
        used: Elements whose content was read.
    """

    findings: list[Finding] = field(default_factory=list)
    locations: dict[Subject, tuple[Path, int | None]] = field(default_factory=dict)
    files: list[Path] = field(default_factory=list)
    elements: int = 0
    roots: list[Node] = field(default_factory=list)
    used: set[etree._Element] = field(default_factory=set)


@dataclass(frozen=True)
class Node:
    """XML element with its file, the object it describes, and the findings.

    If a value is missing or invalid, the error is recorded and a neutral default is returned, so
    that a reader finds all errors at once.

    Attributes:
        file: File of the element.
        subject: Object named in findings.
        notes: Collected findings and locations.
    """

    element: etree._Element
    file: Path
    subject: Subject
    notes: Notes

    @property
    def tag(self) -> str:
        """Tag of the element."""
        return str(self.element.tag)

    @property
    def text(self) -> str:
        """Text of the element, on one line, without leading and trailing spaces."""
        self.notes.used.add(self.element)
        return _single_line(self.element.text or "")

    @property
    def line(self) -> int | None:
        """Line number, counted from 1."""
        return _line(self.element)

    def with_subject(self, subject: Subject) -> Node:
        """Return the element as the description of an object, and record the object's location."""
        self.notes.used.add(self.element)
        self.notes.locations[subject] = (self.file, self.line)
        return Node(self.element, self.file, subject, self.notes)

    def named(self, kind: str, name: str = "name") -> Node:
        """Return the element as the description of the object with the name in an attribute."""
        return self.with_subject(Subject(kind, self.attribute(name)))

    def mark_used(self) -> None:
        """Mark the element and all elements below it as used; see `reading/unread.py`."""
        self.notes.used.update(self.element.iter())

    def error(self, code: str, problem: str, choices: Iterable[str] = ()) -> None:
        """Record an error about this element, and list the choices if there are any."""
        self._note("error", code, problem, choices)

    def warning(self, code: str, problem: str, choices: Iterable[str] = ()) -> None:
        """Record a warning about this element, and list the choices if there are any."""
        self._note("warning", code, problem, choices)

    def all(self, *tags: str) -> list[Node]:
        """Return the child elements with these tags, in order; all children if no tag is given."""
        self.notes.used.add(self.element)
        children = self.element.iterchildren(*tags) if tags else self.element.iterchildren()
        return [Node(child, self.file, self.subject, self.notes) for child in children]

    def optional(self, tag: str) -> Node | None:
        """Return the child with this tag, or None if it does not exist."""
        children = self.all(tag)
        if len(children) > 1:
            children[1].error("repeated-element", f"<{tag}> appears twice; remove one of them")
        return children[0] if children else None

    def required(self, tag: str) -> Node | None:
        """Return the child with this tag; record an error if it does not exist."""
        child = self.optional(tag)
        if child is None:
            self.error("missing-element", f"<{self.tag}> has no <{tag}>")
        return child

    def is_given(self, tag: str) -> bool:
        """Return whether a child has content; an empty child is noted and read as its default."""
        child = self.optional(tag)
        if child is not None and not child.text and not len(child.element):
            child.warning("empty-element", f"<{tag}> is empty; its default value is used")
            return False
        return child is not None

    def has(self, name: str) -> bool:
        """Return whether the element has this attribute."""
        self.notes.used.add(self.element)
        return name in self.element.attrib

    def attribute(self, name: str, default: str | None = None) -> str:
        """Return the value of an attribute, which is required unless a default is given."""
        self.notes.used.add(self.element)
        value = self.element.get(name, default)
        if value is None:
            self.error("missing-attribute", f"<{self.tag}> has no {name!r}")
            return ""
        return _single_line(str(value))

    def number_attribute(
        self, name: str, default: float | None = None, *, infinite: bool = False
    ) -> float:
        """Return the number in an attribute, which is required unless a default is given."""
        if default is not None and not self.has(name):
            return default
        text = self.attribute(name)
        return self._number(text, name, infinite) if self.has(name) else 0.0

    def numbers_attribute(
        self, name: str, size: int, *, infinite: bool = False
    ) -> tuple[float, ...]:
        """Return `size` numbers from a required attribute."""
        text = self.attribute(name)
        return self._numbers(text, name, size, infinite) if self.has(name) else (0.0,) * size

    def number(self, tag: str, default: float | None = None, *, infinite: bool = False) -> float:
        """Return the number in a child element, which is required unless a default is given."""
        if default is not None and not self.is_given(tag):
            return default
        child = self.required(tag)
        if child is None:
            return 0.0
        return child._number(child.text, f"<{tag}>", infinite)

    def vector(self, tag: str) -> Vector3:
        """Return the three numbers in a required child element."""
        child = self.required(tag)
        return ZERO if child is None else child.vector3()

    def vector_attribute(self, name: str) -> Vector3:
        """Return the three numbers in a required attribute."""
        text = self.attribute(name)
        return self._vector(text, name) if self.has(name) else ZERO

    def vector3(self) -> Vector3:
        """Return the three numbers in the text of the element."""
        return self._vector(self.text, f"<{self.tag}>")

    def numbers(self, size: int, *, infinite: bool = False) -> tuple[float, ...]:
        """Return `size` numbers from the text of the element."""
        return self._numbers(self.text, f"<{self.tag}>", size, infinite)

    def integer(self, tag: str) -> int | None:
        """Return the non-negative integer in a required child element, or None on errors."""
        child = self.required(tag)
        if child is None:
            return None
        if not INTEGER.fullmatch(child.text):
            child.error("bad-number", f"<{tag}> {short_repr(child.text)} is not an integer")
            return None
        return int(child.text)

    def _vector(self, text: str, label: str) -> Vector3:
        x, y, z = self._numbers(text, label, 3)
        return x, y, z

    def _numbers(
        self, text: str, label: str, size: int, infinite: bool = False
    ) -> tuple[float, ...]:
        words = text.split()
        if len(words) != size:
            problem = f"{label} {short_repr(text)} must contain {size} numbers, not {len(words)}"
            self.error("bad-vector", problem)
            return (0.0,) * size
        return tuple(self._number(word, label, infinite) for word in words)

    def _number(self, text: str, label: str, infinite: bool) -> float:
        sign = INFINITY.fullmatch(text)
        if infinite and sign:
            return -math.inf if sign[1] == "-" else math.inf
        value = float(text) if NUMBER.fullmatch(text) else math.nan
        if not math.isfinite(value):
            self.error("bad-number", f"{label} {short_repr(text)} is not a finite number")
            return 0.0
        return value

    def _note(
        self, severity: Severity, code: str, problem: str, choices: Iterable[str] = ()
    ) -> None:
        words = ", ".join(choices)
        message = f"{label(self.subject)}: {problem}" + (words and f"; known: {words}")
        self.notes.findings.append(
            Finding(severity, code, message, self.subject, self.file, self.line)
        )


def short_repr(text: str) -> str:
    """Return text from a file, quoted and short_repr to at most 40 characters."""
    return repr(text if len(text) <= 40 else text[:37] + "...")


def _line(element: etree._Element) -> int | None:
    return cast("int | None", element.sourceline)


def _single_line(text: str) -> str:
    return SPACE.sub(" ", text).strip()


def parse(
    file: Path, subject: Subject, notes: Notes, mend: Callable[[bytes], bytes] | None = None
) -> Node:
    """Return the root element of a file.

    No other file is read, and no entity is expanded.

    Args:
        subject: Object named in findings about the file.
        notes: Collects findings, locations and files.
        mend: Function that repairs known syntax errors; it must preserve line numbers.

    Raises:
        InputError: The file cannot be read, is not XML, or uses entities.
    """
    notes.files.append(file)
    parser = etree.XMLParser(
        resolve_entities=False,
        load_dtd=False,
        dtd_validation=False,
        attribute_defaults=False,
        no_network=True,
        huge_tree=False,
        remove_comments=True,
        remove_pis=True,
    )
    data, is_repaired = to_utf8(_bytes(file))
    declared = _declared_entity(data)
    if declared is not None:
        raise InputError(ENTITIES, file=file, line=declared)
    fault = xml_fault(data)
    if fault is not None:
        raise InputError(fault, file=file)
    try:
        root = etree.fromstring(data if mend is None else mend(data), parser)
    except (etree.XMLSyntaxError, ValueError) as error:
        line = getattr(error, "lineno", None)
        reason = str(getattr(error, "msg", None) or error).splitlines()[0]
        raise InputError(f"is not well-formed XML: {reason}", file=file, line=line) from error
    _reject_entities(root, parser, file)
    notes.elements += sum(1 for _ in islice(root.iter(), XML_ELEMENTS + 1))
    if notes.elements > XML_ELEMENTS:
        total = "" if len(notes.files) == 1 else " in total, with the other files of the robot"
        raise InputError(f"has more than {XML_ELEMENTS} elements{total}", file=file)
    node = Node(root, file, subject, notes)
    notes.roots.append(node)
    if is_repaired:
        node.warning("not-utf-8", "bytes that are not UTF-8 are read as Latin-1; save it as UTF-8")
    return node


def _bytes(file: Path) -> bytes:
    """Return the content of a file that is not empty and not too large."""
    data = read_file(file, XML)
    if not data.strip():
        raise InputError("is empty", file=file)
    return data


def _declared_entity(data: bytes) -> int | None:
    """Return the line of the first entity declaration, which is found before parsing.

    Zero bytes are removed first, so that the markup of UTF-16 and UTF-32 documents is found.
    """
    plain = data.replace(b"\0", b"")
    start = plain.find(b"<!ENTITY")
    return None if start < 0 else plain.count(b"\n", 0, start) + 1


def _reject_entities(root: etree._Element, parser: etree.XMLParser, file: Path) -> None:
    for reference in root.iter(etree.Entity):
        raise InputError(ENTITIES, file=file, line=_line(reference))
    for entry in parser.error_log:
        if "ENTITY" in entry.type_name:
            raise InputError(ENTITIES, file=file, line=entry.line)
    internal = root.getroottree().docinfo.internalDTD
    if internal is not None and any(True for _ in internal.iterentities()):  # type: ignore[attr-defined]
        raise InputError(ENTITIES, file=file)
