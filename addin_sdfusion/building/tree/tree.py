"""Kinematic tree of the links of a design: its roots and the parent joint of each link."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import NamedTuple

from ...robot.finding import Finding, Subject
from ...robot.finding_builders import error, unknown, warning
from ...robot.model.robot import WORLD
from ...robot.transforms.joint_chains import Names
from ...settings import ExportSettings
from ...snapshot import MotionSnapshot
from ..joints.edges import Edge, edge_key
from ..links.links import in_name_order
from .disjoint_sets import DisjointSets
from .roots import find_roots

_AXES = (("x", (1.0, 0.0, 0.0)), ("y", (0.0, 1.0, 0.0)), ("z", (0.0, 0.0, 1.0)))
_ANGLES = {"x": "alpha", "y": "beta", "z": "gamma"}


class Branch(NamedTuple):
    """A link with its parent joint.

    Attributes:
        edge: The parent joint.
        parent: The parent link; None for the world.
        child: The link.
    """

    edge: Edge
    parent: str | None
    child: str


class Tree(NamedTuple):
    """Kinematic tree.

    Attributes:
        branches: Links with their parent joints, parents first.
        loops: Names of the joints of each closed loop.
        findings: Findings on the tree.
    """

    branches: tuple[Branch, ...]
    loops: tuple[tuple[str, ...], ...]
    findings: tuple[Finding, ...]


class Graph(NamedTuple):
    """Graph of links and the connections between them.

    Attributes:
        links: Names of the links.
        edges: Connections between links, in order.
        held: Connections that are used only between links without other connections, in order.
        grounded: Links that are fixed to the root component.
        pinned: The grounded links that the user has grounded, not the CAD system.
    """

    links: Sequence[str]
    edges: Sequence[Edge]
    held: Sequence[Edge]
    grounded: Sequence[str]
    pinned: Collection[str]


def find_tree(graph: Graph, settings: ExportSettings, design: str) -> Tree:
    """Return the kinematic tree of a graph.

    Args:
        graph: The links and the connections between them.
        settings: The chosen base, and whether it floats.
        design: Name of the design.
    """
    return _Search(graph, settings, design).tree() if graph.links else Tree((), (), ())


class _Search:
    def __init__(self, graph: Graph, settings: ExportSettings, design: str) -> None:
        self._findings: list[Finding] = []
        self._loops: list[tuple[str, ...]] = []
        self._settings = settings
        self._base = settings.base if settings.base in graph.links else ""
        self._free = Names([*graph.links, *(edge.name for edge in graph.edges)])
        self._bodies = DisjointSets(graph.links)
        self._world = [edge for edge in graph.edges if len(edge.links) == 1]
        self._between = self._without_redundant_edges(graph)
        self._above: dict[str, Branch] = {}
        self._grounded = self._effective_grounds(graph)
        if settings.base and not self._base:
            problem = (
                f"{unknown('link', settings.base, graph.links)}; choose the base again in Export"
            )
            self._findings.append(error(Subject("design", design), "unknown-base", problem))
        self._roots = find_roots(
            self._parts,
            self._between,
            self._world,
            self._grounded,
            self._bodies,
            settings,
            design,
        )
        self._findings += self._roots.findings

    def tree(self) -> Tree:
        for root in self._roots.links:
            floats = root == self._roots.floating
            edge = self._floating_edge(root) if floats else self._fixed_edge(root)
            self._above[root] = Branch(edge, None, root)
            self._add_links_below(root)
        self._close_loops()
        return Tree(tuple(self._above.values()), tuple(self._loops), tuple(self._findings))

    def _without_redundant_edges(self, graph: Graph) -> list[Edge]:
        """Return the edges between links without redundant rigid connections."""
        between = [edge for edge in graph.edges if len(edge.links) == 2]
        joints_first = sorted(between, key=lambda edge: edge.symmetric)
        kept = [
            edge for edge in joints_first if not edge.is_rigid or self._bodies.join(*edge.links)
        ]
        parts = DisjointSets(graph.links)
        for edge in between:
            parts.join(*edge.links)
        for edge in graph.held:
            if parts.join(*edge.links):
                self._bodies.join(*edge.links)
                kept.append(edge)
        self._parts = [in_name_order(part) for part in parts.groups()]
        return sorted(kept, key=edge_key)

    def _effective_grounds(self, graph: Graph) -> list[str]:
        """Return the grounded links to which no joint or user-grounded link takes precedence."""
        kept: list[str] = []
        jointed = {edge.links[0] for edge in self._world}
        for part in self._parts:
            firm = [link for link in part if link in graph.pinned or link in jointed]
            bodies = {self._bodies.find(link) for link in firm}
            for link in (link for link in graph.grounded if link in part):
                same = self._bodies.find(link) in bodies and link not in jointed
                if not firm or link in graph.pinned or same or self._base in part:
                    kept.append(link)
                else:
                    self._findings.append(_ground_ignored(link, firm[0], link in jointed))
        return kept

    def _floating_edge(self, root: str) -> Edge:
        """Return all six motions of the base."""
        name = self._free.unique(f"{WORLD}_{root}")
        for edge in self._world_edges_of(root):
            problem = (
                f"is not exported: it connects {edge.links[0]!r} to the world, but the base floats"
            )
            self._findings.append(warning(Subject("joint", edge.name), "joint-to-ground", problem))
        slides = (MotionSnapshot("translation", axis, role=role) for role, axis in _AXES)
        turns = (MotionSnapshot("rotation", axis, role=_ANGLES[role]) for role, axis in _AXES)
        return Edge(name, root, None, (*slides, *turns), (0.0, 0.0, 0.0))

    def _fixed_edge(self, root: str) -> Edge:
        """Return the edge that connects a root to the world.

        Any other edge to the world closes a loop or is redundant.
        """
        joints = self._world_edges_of(root)
        body = self._bodies.find(root)
        own = [edge for edge in joints if edge.links[0] == root]
        rigid = [edge for edge in own if edge.is_rigid]
        is_grounded = any(self._bodies.find(link) == body for link in self._grounded)
        usable = rigid or ([] if is_grounded else own)
        weld = Edge(f"{WORLD}_{root}", root, None, symmetric=True)
        chosen = usable[0] if usable else replace(weld, name=self._free.unique(weld.name))
        for edge in joints:
            same = self._bodies.find(edge.links[0]) == body
            if edge is not chosen and not (same and edge.is_rigid and chosen.is_rigid):
                self._report_second_ground(edge, root, chosen, same)
        return chosen

    def _report_second_ground(self, edge: Edge, root: str, chosen: Edge, same: bool) -> None:
        by = f"joint {chosen.name!r}" if not chosen.symmetric else "grounding or the chosen base"
        link = edge.links[0]
        if same:
            problem = (
                f"connects link {link!r} to the world, to which it is already fixed by {by}; "
                "unground it, suppress one, or cut this joint in Export"
            )
        else:
            problem = (
                f"connects link {link!r} to the world, to which base {root!r} is fixed by {by}: "
                "this closes a loop; suppress it or cut it in Export"
            )
        joints = {edge.name} if chosen.symmetric else {edge.name, chosen.name}
        self._loops.append(in_name_order(joints))
        self._findings.append(error(Subject("joint", edge.name), "joint-to-ground", problem))

    def _world_edges_of(self, root: str) -> list[Edge]:
        part = next(part for part in self._parts if root in part)
        return [edge for edge in self._world if edge.links[0] in part]

    def _add_links_below(self, root: str) -> None:
        """Add the links below a root, breadth first, in the order of joint names."""
        edges: dict[str, list[Edge]] = {}
        for edge in self._between:
            for link in edge.links:
                edges.setdefault(link, []).append(edge)
        waiting = [root]
        for link in waiting:
            for edge in edges.get(link, ()):
                other = edge.other(link)
                if other is not None and other not in self._above:
                    self._above[other] = Branch(edge, link, other)
                    waiting.append(other)

    def _close_loops(self) -> None:
        used = {branch.edge for branch in self._above.values()}
        for edge in self._between:
            if edge in used or edge.one not in self._above or edge.two not in self._above:
                continue
            one, two = (self._path_to_root(link) for link in edge.links)
            shared = set(one) & set(two)
            others = [branch.edge for branch in (*one, *two) if branch not in shared]
            loop = in_name_order({edge.name, *(e.name for e in others)})
            self._loops.append(loop)
            problem = (
                f"closes a loop of joints {', '.join(map(repr, loop))}; a robot must be a tree: "
                "choose in Export which of them to cut, or suppress one"
            )
            self._findings.append(error(Subject("joint", edge.name), "closed-loop", problem))

    def _path_to_root(self, link: str) -> list[Branch]:
        path = []
        at: str | None = link
        while at is not None:
            path.append(self._above[at])
            at = self._above[at].parent
        return path


def _ground_ignored(link: str, firm: str, jointed: bool) -> Finding:
    why = "a joint connects it to the world" if jointed else f"{firm!r} is fixed to the world"
    problem = (
        "is grounded to its parent, which Fusion does automatically with the first component; this "
        f"is ignored, because {why}. Unground it"
    )
    return warning(Subject("link", link), "ground-ignored", problem)
