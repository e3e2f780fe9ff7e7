"""Tendons of MJCF: spatial ones as paths, fixed ones as sums of coordinates."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ...finding import Subject
from ...finding_builders import unknown
from ...formats.reading.xml import Node
from ...model.muscle import ViaPoint, Wrap, WrapSurface
from ...model.muscle_path import Branch, CoordinateTerm
from .bodies import Body, Part
from .compiler import Compiler
from .document import MAIN, Document
from .shapes import place_of, shape_of, sizes_of

WRAPPED = ("sphere", "cylinder")


@dataclass
class Tendon:
    """A tendon.

    Attributes:
        name: Its name.
        node: Its element.
        points, wraps, branches, terms: As of a muscle.
    """

    name: str
    node: Node
    points: list[ViaPoint] = field(default_factory=list)
    wraps: list[Wrap] = field(default_factory=list)
    branches: list[Branch] = field(default_factory=list)
    terms: list[CoordinateTerm] = field(default_factory=list)


class TendonReader:
    """Reads tendons; collects the surfaces that they wrap over.

    Attributes:
        sites: The sites by name.
        surfaces: All wrap surfaces, by the names of the geoms.
    """

    def __init__(
        self,
        document: Document,
        compiler: Compiler,
        bodies: Sequence[Body],
        coordinates: Sequence[str],
    ) -> None:
        self._document, self._compiler = document, compiler
        self._coordinates = coordinates
        self._geoms = {p.node.attribute("name", ""): p for body in bodies for p in body.geoms}
        self.sites: Mapping[str, ViaPoint] = {
            name: ViaPoint(part.link, place_of(part, compiler).p)
            for body in bodies
            for part in body.sites
            if (name := part.node.attribute("name", ""))
        }
        self.surfaces: dict[str, WrapSurface] = {}

    def read(self) -> dict[str, Tendon]:
        """The tendons by name."""
        found: dict[str, Tendon] = {}
        for k, node in enumerate(self._document.parts("tendon", "spatial", "fixed")):
            node = self._document.with_defaults(node, MAIN, "tendon")
            name = node.attribute("name", "") or f"tendon_{k + 1}"
            if name in found:
                node.error("duplicate-tendon", f"an earlier tendon is called {name!r} too")
                continue
            tendon = Tendon(name, node.about(Subject("muscle", name)))
            (self._spatial if node.tag == "spatial" else self._fixed)(tendon)
            found[name] = tendon
        return found

    def _fixed(self, tendon: Tendon) -> None:
        for node in self._document.children(tendon.node, "joint"):
            joint = node.attribute("joint")
            if joint not in self._coordinates:
                problem = unknown("joint of one coordinate", joint, self._coordinates)
                tendon.node.error("unknown-coordinate", problem)
            else:
                tendon.terms.append(CoordinateTerm(joint, node.number_attribute("coef", 1.0)))

    def _spatial(self, tendon: Tendon) -> None:
        waiting: Node | None = None
        for node in self._document.children(tendon.node):
            if node.tag == "site":
                point = self._site(node, "site")
                if waiting is not None and point is not None:
                    self._wrap(tendon, waiting)
                waiting = None
                if point is not None:
                    tendon.points.append(point)
            elif node.tag == "geom":
                if waiting is not None or not tendon.points:
                    node.error("bad-wrap", "a geom is to be between two sites of a tendon")
                waiting = node
            elif node.tag == "pulley":
                branch = Branch(len(tendon.points), node.number_attribute("divisor"))
                tendon.branches.append(branch)
            else:
                node.error("unsupported-element", f"<{node.tag}> of a tendon is not supported")

    def _site(self, node: Node, word: str) -> ViaPoint | None:
        name = node.attribute(word)
        if name not in self.sites:
            node.error("unknown-site", unknown("site", name, list(self.sites)))
            return None
        return self.sites[name]

    def _wrap(self, tendon: Tendon, node: Node) -> None:
        name = node.attribute("geom")
        part = self._geoms.get(name)
        if part is None or not name:
            node.error("unknown-wrap-surface", unknown("geom", name, list(self._geoms)))
            return
        side = self._site(node, "sidesite") if node.has("sidesite") else None
        if name not in self.surfaces:
            surface = self._surface(name, part)
            if surface is None:
                return
            self.surfaces[name] = surface
        segment = len(tendon.points) - 1
        tendon.wraps.append(Wrap(name, segment, rule="mujoco", side_point=side))

    def _surface(self, name: str, part: Part) -> WrapSurface | None:
        """The surface of a geom; cylinders have no ends in MuJoCo."""
        kind = shape_of(part.node)
        if kind not in WRAPPED:
            problem = f"tendons wrap over spheres and cylinders, not over a {kind[:20]!r}"
            part.node.error("unsupported-wrap-shape", problem)
            return None
        pose = self._compiler.pose(part.node, place_of(part, self._compiler))
        radius = sizes_of(part.node)[0]
        shape = "sphere" if kind == "sphere" else "cylinder"
        return WrapSurface(name, part.link, shape, radius, pose, math.inf)  # type: ignore[arg-type]
