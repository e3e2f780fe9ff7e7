"""Size of the scene in a COLLADA file. A few nodes can instantiate a geometry many times."""

from __future__ import annotations

from dataclasses import dataclass, field
from xml.parsers import expat

from . import limits

_FACES = {"triangles", "trifans", "tristrips", "polylist", "polygons"}


@dataclass
class _Node:
    """A node, or the root of a scene, with its instances.

    Attributes:
        geometries, nodes: Names of the geometries and nodes that it instantiates.
        inner: Child nodes.
        counts: Numbers of parts and of values below this node, or None if not counted yet.
    """

    geometries: list[str] = field(default_factory=list)
    nodes: list[str] = field(default_factory=list)
    inner: list[_Node] = field(default_factory=list)
    counts: tuple[int, int] | None = None


class ColladaScene:
    """Contents of a COLLADA file, counted while the file is parsed.

    Raises:
        ValueError: The file declares XML entities.
        expat.ExpatError: The file is not XML.
    """

    def __init__(self, data: bytes) -> None:
        self.elements: set[str] = set()
        self._scenes: list[_Node] = []
        self._open: list[_Node] = []
        self._nodes: dict[str, _Node] = {}
        self._sizes: dict[str, int] = {}
        self._parts: dict[str, int] = {}
        self._geometry: str | None = None
        parser = expat.ParserCreate()
        parser.buffer_text = True
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._text
        parser.EntityDeclHandler = self._entity
        parser.Parse(data, True)

    def fault(self) -> str | None:
        """Return the reason why the file is not a usable mesh, or None."""
        if "COLLADA" not in self.elements or self.elements.isdisjoint(_FACES):
            return "it is not a .dae mesh: it has no faces"
        placed = [self._count(scene, 0) for scene in self._scenes]
        if sum(parts for parts, _ in placed) > limits.MESH_NODES:
            return f"its scene has more than {limits.MESH_NODES} parts"
        if sum(numbers for _, numbers in placed) > limits.MESH_NUMBERS:
            return f"its scene has more than {limits.MESH_NUMBERS} numbers"
        return None

    def _count(self, node: _Node, depth: int) -> tuple[int, int]:
        """Return the number of nodes and geometry parts below a node, and of their values."""
        if depth > limits.MESH_DEPTH:
            raise ValueError(f"its nodes are nested more than {limits.MESH_DEPTH} deep")
        if node.counts is None:
            below = [*node.inner, *(self._nodes[n] for n in node.nodes if n in self._nodes)]
            placed = [self._count(child, depth + 1) for child in below]
            parts = 1 + sum(self._parts.get(name, 1) for name in node.geometries)
            parts += sum(parts for parts, _ in placed)
            numbers = sum(self._sizes.get(name, 0) for name in node.geometries)
            node.counts = parts, numbers + sum(numbers for _, numbers in placed)
        return node.counts

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        name = name.rpartition(":")[2]
        self.elements.add(name)
        if name in ("node", "visual_scene"):
            node = _Node()
            if name == "visual_scene":
                self._scenes.append(node)
            elif self._open:
                self._open[-1].inner.append(node)
            self._nodes.setdefault(attributes.get("id", ""), node)
            self._open.append(node)
        elif name == "geometry":
            self._geometry = attributes.get("id", "")
        elif name in _FACES and self._geometry is not None:
            self._parts[self._geometry] = self._parts.get(self._geometry, 0) + 1
        elif name in ("instance_geometry", "instance_node") and self._open:
            place = self._open[-1]
            names = place.nodes if name == "instance_node" else place.geometries
            names.append(attributes.get("url", "").removeprefix("#"))

    def _end(self, name: str) -> None:
        name = name.rpartition(":")[2]
        if name in ("node", "visual_scene"):
            self._open.pop()
        elif name == "geometry":
            self._geometry = None

    def _text(self, text: str) -> None:
        if self._geometry is not None:
            count = self._sizes.get(self._geometry, 0) + len(text.split())
            self._sizes[self._geometry] = count

    def _entity(self, *_: object) -> None:
        raise ValueError("it declares XML entities")
