"""An MJCF file with what it includes, as one text for MuJoCo that names no file.

MuJoCo would open whatever a file names. So includes are put in place here, by the rules of all
files from outside (`formats/reading/xml.py`), meshes get keys instead of paths, and what this
package has no use for, such as textures, plugins or sensors, is taken out; what matters of that is
a finding.
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
from ..reading.xml import ABSOLUTE, Node, Notes, parse, shortened

MAX_INCLUDED = 100
"""So many files may be included."""
MAX_COPIES = 10_000
"""So many elements may be made by `<replicate>`."""
INITIAL = "initial"
"""The keyframe of our own files with the initial values."""
LEFT_OUT = ("sensor", "contact", "deformable", "extension", "keyframe", "custom")
"""Sections whose parts are left out, each with a finding."""
SEEN_ONLY = ("visual", "statistic", "light", "camera", "texture", "material", "skin", "size")
"""Elements that change nothing of the robot, nor how it moves."""
SOFT = ("composite", "flexcomp")
"""What makes ropes, cloths and soft bodies."""
OF_SOFT = ("flex", "flexvert", "flexstrain")
"""Equalities of soft bodies."""
OWN_FLAGS = ("meshdir", "texturedir", "assetdir", "strippath", "discardvisual")
"""Flags of the compiler that count here: MuJoCo sees no files."""

_CLOSE = re.compile(rb'(="[^"<>]*")(?=[A-Za-z_])')
_COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)
_NAN = re.compile(r"(^|\s)[+-]?nan($|[\s(])", re.ASCII | re.IGNORECASE)


class Document:
    """A file with all that it includes, read and checked.

    Attributes:
        root: Its `<mujoco>`.
        mesh_files: Of each key that a mesh has instead of a path, the file; those that are there.
        uris: Of each mesh, by its name, the file that it names, from the folder of the model.
    """

    def __init__(self, file: Path, notes: Notes) -> None:
        self._files: dict[etree._Element, Path] = {}
        root = parse(file, Subject("robot", file.stem), notes, mend=_as_xml)
        if root.tag != "mujoco":
            raise InputError(f"<{root.tag}> is not <mujoco>", file=file, line=root.line)
        self.root = root.about(Subject("robot", root.attribute("model", "") or file.stem))
        self._own(self.root)
        self._put_includes_in_place()
        self.mesh_files: dict[str, Path] = {}
        self.uris: dict[str, str] = {}
        self._meshes: dict[str, Node] = {}
        self._name_meshes(*self._mesh_folder())
        self._refuse_copies()
        self._leave_out()
        self._lines = self._numbered_lines()

    def node(self, element: etree._Element) -> Node:
        """Return an element with its file."""
        return Node(element, self._files[element], self.root.subject, self.root.notes)

    def node_at(self, line: int) -> Node:
        """Return the element at a line of `text`, the root if there is none."""
        return self.node(self._lines[line]) if 0 < line < len(self._lines) else self.root

    def first(self, tag: str) -> Node:
        """Return the first element of a kind, the root if there is none."""
        return next(iter(self._all(tag)), self.root)

    def text(self) -> str:
        """Return the text for MuJoCo: each element begins a line."""
        return etree.tostring(self.root.element, encoding="unicode")

    def with_files(self, text: str) -> str:
        """Return a message of MuJoCo with the files of meshes in place of their keys."""
        for key, node in self._meshes.items():
            text = text.replace(key, self.uris[node.attribute("name")])
        return text

    def note_read(self, key: str) -> None:
        """Note that a mesh was read, as one of the robot's files."""
        node = self._meshes[key]
        note_absolute(node, self.uris[node.attribute("name")])
        node.notes.files.append(self.mesh_files[key])

    def _own(self, root: Node) -> None:
        """Remember the file of each element; values become lines without space around them."""
        for element in root.element.iter():
            self._files[element] = root.file
            for name, value in element.attrib.items():
                element.set(name, " ".join(str(value).split()))

    def _all(self, *tags: str) -> list[Node]:
        return [self.node(element) for element in self.root.element.iter(*tags)]

    def _put_includes_in_place(self) -> None:
        """Put the children of included files in place of `<include>`, each file once."""
        included = {self.root.file.resolve()}
        while includes := self._all("include"):
            for include in includes:
                file = self._included_file(include)
                children: list[etree._Element] = []
                if file.resolve() in included or len(included) > MAX_INCLUDED:
                    name = include.attribute("file")
                    problem = f"{name!r} is included already, or too many files are"
                    include.error("included-twice", problem)
                else:
                    included.add(file.resolve())
                    root = parse(file, include.subject, include.notes, mend=_as_xml)
                    self._own(root)
                    children = list(root.element)
                above = include.element.getparent()
                assert above is not None  # the root is <mujoco>
                at = above.index(include.element)
                above[at : at + 1] = children

    def _included_file(self, include: Node) -> Path:
        """From next to the model or, as in MuJoCo, next to the file that includes it."""
        name = include.attribute("file")
        note_absolute(include, name)
        beside = [self.root.file.parent / name, include.file.parent / name]
        return next((file for file in beside if is_file(file)), beside[0])

    def _mesh_folder(self) -> tuple[str, bool]:
        """Where meshes are, from the model's folder, and whether only their files' names count."""
        folder, strips = "", False
        for node in self._all("compiler"):
            folder = node.attribute("meshdir", node.attribute("assetdir", folder))
            if node.has("strippath"):
                strips = node.attribute("strippath") == "true"
            for name in OWN_FLAGS:
                node.element.attrib.pop(name, "")
        return folder, strips

    def _name_meshes(self, folder: str, strips: bool) -> None:
        """Give meshes keys in place of their files."""
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

    def _refuse_copies(self) -> None:
        """Reject `<replicate>` where it makes too many elements."""
        made, inside = 0.0, [(self.root, 1.0)]
        for event, element in etree.iterwalk(self.root.element, events=("start", "end")):
            if element.tag != "replicate":
                made += inside[-1][1] if event == "start" and len(inside) > 1 else 0.0
            elif event == "start":
                node = self.node(element)
                count = max(node.number_attribute("count", 0.0), 0.0)
                inside.append((node, inside[-1][1] * count))
            else:
                inside.pop()
            if made > MAX_COPIES:
                problem = f"<replicate> makes over {MAX_COPIES} elements"
                inside[1][0].error("too-many-copies", problem)
                return

    def _leave_out(self) -> None:
        """Take out what is not for MuJoCo; note what matters of it."""
        for tag in LEFT_OUT:
            sections = self.root.all(tag)
            parts = [self.node(part) for section in sections for part in section.element]
            parts = [part for part in parts if part.attribute("name", "") != INITIAL]
            if parts:
                names = ", ".join(repr(part.attribute("name", part.tag)) for part in parts[:10])
                parts[0].warning("part-left-out", f"{len(parts)} of <{tag}> left out: {names}")
            for gone in parts if tag == "keyframe" else sections:
                _remove(gone.element)
        for node in self._all(*SOFT):
            problem = f"<{node.tag}> is left out; have MuJoCo save the model, which expands it"
            node.warning("soft-body-left-out", problem)
        for node in self._all("attach"):
            problem = "<attach> is not supported; have MuJoCo save the model, which expands it"
            node.error("unsupported-element", problem)
        for node in self._all("plugin"):
            node.warning("part-left-out", f"a plugin of <{_parent(node)}> is left out")
        for node in self._all("frame"):
            if node.has("scale") and self.uris:
                node.warning("meshes-not-scaled", "meshes in it are shown without its scale")
        for node in self._all("equality"):
            for each in map(self.node, node.element.iterchildren(*OF_SOFT)):
                note_equality(each)
                _remove(each.element)
        assets = [
            part for node in self._all("asset") for part in node.element if part.tag != "mesh"
        ]
        for element in [*assets, *self.root.element.iter(*SEEN_ONLY, *SOFT, "plugin")]:
            _remove(element)
        users = [node for node in self._all() if node.has("user")]
        if users:
            problem = f"the user data of {len(users)} elements is left out"
            users[0].warning("part-left-out", problem)
        for node in self._all():
            node.element.attrib.pop("material", "")
            for name, value in node.element.attrib.items():
                if _NAN.search(str(value)) and name != "name":
                    problem = f"{name!s} {shortened(str(value))} is not a finite number"
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
    """Note an equality that is left out."""
    name = node.attribute("name", "")
    problem = (
        f"equality <{node.tag}> {name!r} is not supported: what it holds is free here, and "
        "the robot moves otherwise"
    )
    node.warning("equality-left-out", problem)


def note_absolute(node: Node, name: str) -> None:
    """Warn of a file of the robot that is named by a path of this machine."""
    if Path(name.removeprefix("file://")).is_absolute():
        problem = (
            f"{shortened(name)} is a path on this machine alone: what is written of the robot "
            "could not be read elsewhere; name it by its path from the folder of this file"
        )
        node.warning(ABSOLUTE, problem)


def _remove(element: etree._Element) -> None:
    parent = element.getparent()
    if parent is not None:
        parent.remove(element)


def _parent(node: Node) -> str:
    above = node.element.getparent()
    return "" if above is None else str(above.tag)


def _may_be_read(file: Path) -> bool:
    """Return whether a mesh is there, is a file, and is not too large."""
    try:
        open_file(file, MESH).close()
    except InputError:
        return False
    return True


def _as_xml(data: bytes) -> bytes:
    """Without comments, in which MuJoCo takes `--`, and with spaces between attributes."""
    parts = _COMMENT.split(data)
    comments = [*(b"\n" * comment.count(b"\n") for comment in _COMMENT.findall(data)), b""]
    return b"".join(
        _CLOSE.sub(rb"\1 ", part) + lines for part, lines in zip(parts, comments, strict=True)
    )
