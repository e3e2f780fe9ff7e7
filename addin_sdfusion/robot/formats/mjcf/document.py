"""MJCF file with all its includes, as one text for MuJoCo without file names.

MuJoCo opens all files that an MJCF file names. Therefore includes are resolved here, with the rules
for untrusted files (`formats/reading/xml.py`). Mesh paths are replaced by keys. Elements that are
not used, such as textures, plugins and sensors, are removed; relevant ones are reported.
"""

from __future__ import annotations

import re
from pathlib import Path, PurePosixPath

from lxml import etree

from ...errors import InputError
from ...files import open_file
from ...finding import Subject
from ...limits import MESH
from ...mesh_files import is_file, mesh_file
from ..reading.xml import ABSOLUTE, Node, Notes, parse, short_repr

MAX_INCLUDED = 100
"""Maximum number of included files."""
MAX_COPIES = 10_000
"""Maximum number of elements created by `<replicate>`."""
INITIAL = "initial"
"""Keyframe with the initial values, in files written by this package."""
OMITTED_SECTIONS = ("sensor", "contact", "deformable", "extension", "keyframe", "custom")
"""Sections whose elements are omitted, with a finding."""
VISUAL_ONLY = ("visual", "statistic", "light", "camera", "texture", "material", "skin", "size")
"""Elements that affect neither the robot nor its motion."""
SOFT = ("composite", "flexcomp")
"""Elements that generate ropes, cloth and soft bodies."""
OF_SOFT = ("flex", "flexvert", "flexstrain")
"""Equalities of soft bodies."""
FILE_ATTRIBUTES = ("meshdir", "texturedir", "assetdir", "strippath", "discardvisual")
"""Attributes of `<compiler>` that are evaluated here, because MuJoCo gets no files."""

_CLOSE = re.compile(rb'(="[^"<>]*")(?=[A-Za-z_])')
_COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)
_NAN = re.compile(r"(^|\s)[+-]?nan($|[\s(])", re.ASCII | re.IGNORECASE)


class Document:
    """MJCF file with all its includes, read and checked.

    Attributes:
        root: The `<mujoco>` element.
        mesh_files: Existing mesh files by the key that replaces the path.
        uris: Mesh file relative to the model folder, by the name of the mesh.
    """

    def __init__(self, file: Path, notes: Notes) -> None:
        self._files: dict[etree._Element, Path] = {}
        root = parse(file, Subject("robot", file.stem), notes, mend=_repair_xml)
        if root.tag != "mujoco":
            raise InputError(f"<{root.tag}> is not <mujoco>", file=file, line=root.line)
        self.root = root.with_subject(Subject("robot", root.attribute("model", "") or file.stem))
        self._record_elements(self.root)
        self._resolve_includes()
        self.mesh_files: dict[str, Path] = {}
        self.uris: dict[str, str] = {}
        self._meshes: dict[str, Node] = {}
        self._name_meshes(*self._mesh_folder())
        self._reject_copies()
        self._remove_unused()
        self._lines = self._numbered_lines()

    def node(self, element: etree._Element) -> Node:
        """Return an element as a node with its file."""
        return Node(element, self._files[element], self.root.subject, self.root.notes)

    def node_at(self, line: int) -> Node:
        """Return the element at a line of `text`, or the root if none exists."""
        return self.node(self._lines[line]) if 0 < line < len(self._lines) else self.root

    def first(self, tag: str) -> Node:
        """Return the first element of a kind, or the root if none exists."""
        return next(iter(self._all(tag)), self.root)

    def text(self) -> str:
        """Return the text for MuJoCo, with each element on a new line."""
        return etree.tostring(self.root.element, encoding="unicode")

    def with_files(self, text: str) -> str:
        """Return a message of MuJoCo with mesh keys replaced by file names."""
        for key, node in self._meshes.items():
            text = text.replace(key, self.uris[node.attribute("name")])
        return text

    def note_read(self, key: str) -> None:
        """Record a mesh file as one of the files of the robot."""
        node = self._meshes[key]
        note_absolute(node, self.uris[node.attribute("name")])
        node.notes.files.append(self.mesh_files[key])

    def _record_elements(self, root: Node) -> None:
        """Record the file of each element, and reduce whitespace in attributes."""
        for element in root.element.iter():
            self._files[element] = root.file
            for name, value in element.attrib.items():
                element.set(name, " ".join(str(value).split()))

    def _all(self, *tags: str) -> list[Node]:
        return [self.node(element) for element in self.root.element.iter(*tags)]

    def _resolve_includes(self) -> None:
        """Replace each `<include>` by the children of the file; each file is included once."""
        included = {self.root.file.resolve()}
        while includes := self._all("include"):
            for include in includes:
                file = self._included_file(include)
                children: list[etree._Element] = []
                if file.resolve() in included or len(included) > MAX_INCLUDED:
                    name = include.attribute("file")
                    problem = f"{name!r} is already included, or too many files are included"
                    include.error("included-twice", problem)
                else:
                    included.add(file.resolve())
                    root = parse(file, include.subject, include.notes, mend=_repair_xml)
                    self._record_elements(root)
                    children = list(root.element)
                parent = include.element.getparent()
                assert parent is not None  # the root is <mujoco>
                at = parent.index(include.element)
                parent[at : at + 1] = children

    def _included_file(self, include: Node) -> Path:
        """Return the included file, relative to the model or, as in MuJoCo, to its includer."""
        name = include.attribute("file")
        note_absolute(include, name)
        candidates = [self.root.file.parent / name, include.file.parent / name]
        return next((file for file in candidates if is_file(file)), candidates[0])

    def _mesh_folder(self) -> tuple[str, bool]:
        """Return the mesh folder relative to the model, and whether mesh paths are stripped."""
        folder, strips = "", False
        for node in self._all("compiler"):
            folder = node.attribute("meshdir", node.attribute("assetdir", folder))
            if node.has("strippath"):
                strips = node.attribute("strippath") == "true"
            for name in FILE_ATTRIBUTES:
                node.element.attrib.pop(name, "")
        return folder, strips

    def _name_meshes(self, folder: str, strips: bool) -> None:
        """Replace the files of meshes by keys."""
        home = self.root.file.parent
        for k, node in enumerate(self._all("mesh")):
            if not node.has("file") or _parent(node) != "asset":
                continue
            path = PurePosixPath(node.attribute("file"))
            name = node.attribute("name", "") or path.stem
            self.uris[name] = str(PurePosixPath(folder) / (path.name if strips else path))
            key = f"mesh_{k}_{path.suffix.lower()}"
            node.element.set("name", name)
            node.element.set("file", key)
            self._meshes[key] = node
            file = mesh_file(self.uris[name], home, [home])
            if _may_be_read(file):
                self.mesh_files[key] = file

    def _reject_copies(self) -> None:
        """Record an error if `<replicate>` creates too many elements."""
        count, inside = 0.0, [(self.root, 1.0)]
        for event, element in etree.iterwalk(self.root.element, events=("start", "end")):
            if element.tag != "replicate":
                count += inside[-1][1] if event == "start" and len(inside) > 1 else 0.0
            elif event == "start":
                node = self.node(element)
                copies = max(node.number_attribute("count", 0.0), 0.0)
                inside.append((node, inside[-1][1] * copies))
            else:
                inside.pop()
            if count > MAX_COPIES:
                problem = f"<replicate> creates more than {MAX_COPIES} elements"
                inside[1][0].error("too-many-copies", problem)
                return

    def _remove_unused(self) -> None:
        """Remove elements that MuJoCo does not need; report the relevant ones."""
        for tag in OMITTED_SECTIONS:
            sections = self.root.all(tag)
            parts = [self.node(part) for section in sections for part in section.element]
            parts = [part for part in parts if part.attribute("name", "") != INITIAL]
            if parts:
                names = ", ".join(repr(part.attribute("name", part.tag)) for part in parts[:10])
                parts[0].warning("part-left-out", f"{len(parts)} of <{tag}> omitted: {names}")
            for unused in parts if tag == "keyframe" else sections:
                _remove(unused.element)
        for node in self._all(*SOFT):
            problem = f"<{node.tag}> is omitted; save the model in MuJoCo, which expands it"
            node.warning("soft-body-left-out", problem)
        for node in self._all("attach"):
            problem = "<attach> is not supported; save the model in MuJoCo, which expands it"
            node.error("unsupported-element", problem)
        for node in self._all("plugin"):
            parent = _parent(node)
            code = "actuator-left-out" if parent == "actuator" else "part-left-out"
            node.warning(code, f"a plugin of <{parent}> is omitted")
        for node in self._all("frame"):
            if node.has("scale") and self.uris:
                node.warning("meshes-not-scaled", "meshes in the frame are shown without its scale")
        for node in self._all("equality"):
            for item in map(self.node, node.element.iterchildren(*OF_SOFT)):
                note_equality(item)
                _remove(item.element)
        assets = [
            part for node in self._all("asset") for part in node.element if part.tag != "mesh"
        ]
        for element in [*assets, *self.root.element.iter(*VISUAL_ONLY, *SOFT, "plugin")]:
            _remove(element)
        users = [node for node in self._all() if node.has("user")]
        if users:
            problem = f"the user data of {len(users)} elements is omitted"
            users[0].warning("part-left-out", problem)
        for node in self._all():
            node.element.attrib.pop("material", "")
            for name, value in node.element.attrib.items():
                if _NAN.search(str(value)) and name != "name":
                    problem = f"{name!s} {short_repr(str(value))} is not a finite number"
                    node.error("bad-number", problem)

    def _numbered_lines(self) -> list[etree._Element]:
        """Return the element on each line of `text`, counted from 1."""
        lines = [self.root.element]
        for event, element in etree.iterwalk(self.root.element, events=("start", "end")):
            element.tail = "\n"
            element.text = "\n" if len(element) else None
            if event == "start" or len(element):
                lines.append(element)
        return lines


def note_equality(node: Node) -> None:
    """Report an equality that is not supported."""
    name = node.attribute("name", "")
    problem = (
        f"equality <{node.tag}> {name!r} is not supported and is ignored; the motion of the robot "
        "differs"
    )
    node.warning("equality-left-out", problem)


def note_absolute(node: Node, name: str) -> None:
    """Report a file that is given by an absolute path."""
    if Path(name.removeprefix("file://")).is_absolute():
        problem = (
            f"{short_repr(name)} is an absolute path, which is invalid elsewhere; use a path "
            "relative to the folder of this file"
        )
        node.warning(ABSOLUTE, problem)


def _remove(element: etree._Element) -> None:
    parent = element.getparent()
    if parent is not None:
        parent.remove(element)


def _parent(node: Node) -> str:
    parent = node.element.getparent()
    return "" if parent is None else str(parent.tag)


def _may_be_read(file: Path) -> bool:
    """Return whether a mesh file exists and is not too large."""
    try:
        open_file(file, MESH).close()
    except InputError:
        return False
    return True


def _repair_xml(data: bytes) -> bytes:
    """Return the text without comments, in which MuJoCo allows `--`, and with added spaces."""
    parts = _COMMENT.split(data)
    comments = [*(b"\n" * comment.count(b"\n") for comment in _COMMENT.findall(data)), b""]
    return b"".join(
        _CLOSE.sub(rb"\1 ", part) + lines for part, lines in zip(parts, comments, strict=True)
    )
