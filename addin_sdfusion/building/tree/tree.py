"""Kinematic tree of the links of a design: its roots and the parent joint of each link."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from ...robot.finding import Finding, Subject
from ...robot.finding_builders import error, unknown, warning
from ...robot.model.pose import AXES
from ...robot.model.robot import WORLD
from ...robot.transforms.joint_chains import Names
from ...settings import ExportSettings
from ...snapshot import MotionSnapshot
from ..joints.edges import Edge, edge_key
from ..links.links import in_name_order
from .cuts import UNSUPPORTED, best_cut, cutting_cost
from .disjoint_sets import DisjointSets
from .roots import find_roots

_AXES = tuple(zip("xyz", AXES, strict=True))
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
        closings: The edges at which closed loops are cut, by name.
        loops: Names of the joints of each closed loop.
    """

    branches: tuple[Branch, ...]
    closings: tuple[Edge, ...]
    loops: tuple[tuple[str, ...], ...]
    findings: tuple[Finding, ...]


class Graph(NamedTuple):
    """Graph of links and the connections between them.

    Attributes:
        edges: Connections between links, in order.
        grounding: Connections that are used only between links without other connections, in order.
        cut: Connections that the user has chosen to close loops, in order.
        grounded: Links that are fixed to the root component.
        pinned: The grounded links that the user has grounded, not the CAD system.
    """

    links: Sequence[str]
    edges: Sequence[Edge]
    grounding: Sequence[Edge]
    cut: Sequence[Edge]
    grounded: Sequence[str]
    pinned: Collection[str]


def find_tree(graph: Graph, settings: ExportSettings, design: str) -> Tree:
    """Return the kinematic tree of a graph."""
    return _Search(graph, settings, design).tree() if graph.links else Tree((), (), (), ())


class _Search:
    def __init__(self, graph: Graph, settings: ExportSettings, design: str) -> None:
        self._findings: list[Finding] = []
        self._chosen = graph.cut
        self._cut: set[Edge] = set()
        self._settings = settings
        self._base = settings.base if settings.base in graph.links else ""
        self._free = Names([*graph.links, *(e.name for e in (*graph.edges, *graph.cut))])
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
            self._groups,
            self._between,
            self._world,
            self._grounded,
            self._bodies,
            settings,
            design,
        )
        self._findings += self._roots.findings

    def tree(self) -> Tree:
        links = self._roots.links
        edges = [
            self._floating_edge(r) if r == self._roots.floating else self._fixed_edge(r)
            for r in links
        ]
        roots = [Branch(edge, None, link) for edge, link in zip(edges, links, strict=True)]
        self._grow(roots)
        while (edge := self._better_cut(roots)) is not None:
            self._cut.add(edge)
            self._grow(roots)
        loops = {
            edge: in_name_order({e.name for e in self._loop(edge)}) for edge in self._closings()
        }
        for edge in self._chosen:
            if self._has_effect(edge):
                loops[edge] = in_name_order({e.name for e in self._loop(edge)})
        closings = [edge for edge in sorted(loops, key=edge_key) if self._can_close(edge, loops)]
        return Tree(
            tuple(self._above.values()),
            tuple(closings),
            tuple(loops[edge] for edge in sorted(loops, key=edge_key)),
            tuple(self._findings),
        )

    def _without_redundant_edges(self, graph: Graph) -> list[Edge]:
        """Return the edges between links without redundant rigid connections."""
        between = [edge for edge in graph.edges if len(edge.links) == 2]
        joints_first = sorted(between, key=lambda edge: edge.symmetric)
        needed = [
            edge for edge in joints_first if not edge.is_rigid or self._bodies.join(*edge.links)
        ]
        groups = DisjointSets(graph.links)
        for edge in between:
            groups.join(*edge.links)
        for edge in graph.grounding:
            if groups.join(*edge.links):
                self._bodies.join(*edge.links)
                needed.append(edge)
        self._groups = [in_name_order(group) for group in groups.groups()]
        return sorted(needed, key=edge_key)

    def _effective_grounds(self, graph: Graph) -> list[str]:
        """Return the grounded links to which no joint or user-grounded link takes precedence."""
        effective: list[str] = []
        jointed = {edge.links[0] for edge in self._world}
        for group in self._groups:
            firm = [link for link in group if link in graph.pinned or link in jointed]
            bodies = {self._bodies.find(link) for link in firm}
            for link in (link for link in graph.grounded if link in group):
                same = self._bodies.find(link) in bodies and link not in jointed
                if not firm or link in graph.pinned or same or self._base in group:
                    effective.append(link)
                else:
                    self._findings.append(_ground_ignored(link, firm[0], link in jointed))
        return effective

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
        edges_of_root = [edge for edge in joints if edge.links[0] == root]
        rigid = [edge for edge in edges_of_root if edge.is_rigid]
        is_grounded = any(self._bodies.find(link) == body for link in self._grounded)
        usable = rigid or ([] if is_grounded else edges_of_root)
        weld = Edge(f"{WORLD}_{root}", root, None, symmetric=True)
        chosen = usable[0] if usable else replace(weld, name=self._free.unique(weld.name))
        for edge in joints:
            same = self._bodies.find(edge.links[0]) == body
            if same and chosen.is_rigid and edge is not chosen:
                self._world.remove(edge)
                if not edge.is_rigid:
                    self._report_second_ground(edge, chosen)
        return chosen

    def _report_second_ground(self, edge: Edge, chosen: Edge) -> None:
        by = f"joint {chosen.name!r}" if not chosen.symmetric else "grounding or the chosen base"
        problem = (
            f"connects link {edge.links[0]!r} to the world, to which it is already fixed by {by}; "
            "unground it, suppress one, or cut this joint in Export"
        )
        self._findings.append(error(Subject("joint", edge.name), "joint-to-ground", problem))

    def _world_edges_of(self, root: str) -> list[Edge]:
        group = next(group for group in self._groups if root in group)
        return [edge for edge in self._world if edge.links[0] in group]

    def _grow(self, roots: Sequence[Branch]) -> None:
        """Find the tree without the cut edges, breadth first, in the order of joint names.

        Links with joints to the world are at the first level, like the roots.
        """
        self._above = {}
        edges: dict[str, list[Edge]] = {}
        for edge in self._between:
            for link in edge.links if edge not in self._cut else ():
                edges.setdefault(link, []).append(edge)
        for root in roots:
            self._above[root.child] = root
        for edge in self._free_world_edges(roots):
            if edge not in self._cut:
                self._above.setdefault(edge.links[0], Branch(edge, None, edge.links[0]))
        waiting = list(self._above)
        for link in waiting:
            for edge in edges.get(link, ()):
                other = edge.other(link)
                if other is not None and other not in self._above:
                    self._above[other] = Branch(edge, link, other)
                    waiting.append(other)

    def _free_world_edges(self, roots: Sequence[Branch]) -> list[Edge]:
        """Return the joints to the world that are not edges of roots; none if the base floats."""
        used = {root.edge for root in roots}
        floating = self._roots.floating
        ignored = set(self._world_edges_of(floating)) if floating else set[Edge]()
        return [edge for edge in self._world if edge not in used and edge not in ignored]

    def _closings(self) -> list[Edge]:
        """Return the edges that close loops, except the ones that the user has chosen."""
        used = {branch.edge for branch in self._above.values()}
        roots = [branch for branch in self._above.values() if branch.parent is None]
        between = [edge for edge in self._between if all(e in self._above for e in edge.links)]
        return [e for e in (*between, *self._free_world_edges(roots)) if e not in used]

    def _better_cut(self, roots: Sequence[Branch]) -> Edge | None:
        """Return an edge whose cut costs less than the cut of an edge that closes its loop."""
        firm = {root.edge for root in roots}
        for edge in self._closings():
            best = best_cut(edge, [e for e in self._loop(edge) if e not in firm])
            if best is not edge and best not in self._cut:
                return best
        return None

    def _loop(self, edge: Edge) -> list[Edge]:
        """Return the edge and the edges of the tree that form a loop with it.

        Connections of roots that are not joints are omitted.
        """
        one, *others = (self._path_to_root(link) for link in edge.links if link in self._above)
        two = others[0] if others else []
        shared = set(one) & set(two)
        around = [branch.edge for branch in (*one, *two) if branch not in shared]
        return [edge, *(e for e in around if len(e.links) > 1 or not e.symmetric)]

    def _has_effect(self, edge: Edge) -> bool:
        """Return whether the links of a chosen edge can move relative to each other."""
        reached = [link for link in edge.links if link in self._above]
        if len(reached) < len(edge.links):
            return False
        bodies = {self._bodies.find(link) for link in edge.links}
        if len(edge.links) == 1:
            roots = [branch for branch in self._above.values() if branch.parent is None]
            fixed = {self._bodies.find(root.child) for root in roots if root.edge.is_rigid}
            is_stuck = bool(self._roots.floating or bodies & fixed)
        else:
            is_stuck = len(bodies) == 1
        if is_stuck:
            problem = "is cut and not exported: the parts that it connects cannot move against it"
            self._findings.append(warning(Subject("joint", edge.name), "cut-joint", problem))
            return False
        return True

    def _can_close(self, edge: Edge, loops: Mapping[Edge, Sequence[str]]) -> bool:
        """Report how a loop is closed; return whether the edge can close it."""
        subject, names = Subject("joint", edge.name), ", ".join(map(repr, loops[edge]))
        if cutting_cost(edge) < UNSUPPORTED:
            if edge not in self._chosen:
                problem = (
                    f"closes a loop of joints {names}; it is exported as a loop joint without "
                    "coordinates. To cut the loop at another joint, choose it in Export"
                )
                self._findings.append(warning(subject, "closed-loop", problem))
            return True
        if edge in self._chosen:
            problem = (
                f"is cut and not exported: its motions cannot close the loop of joints {names}, "
                "which is open. Cut another joint in Export"
            )
            self._findings.append(warning(subject, "cut-joint", problem))
        else:
            problem = (
                f"closes a loop of joints {names}, but no loop joint has the motions of one of "
                "them; suppress one of them, or cut one in Export to open the loop"
            )
            self._findings.append(error(subject, "closed-loop", problem))
        return False

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
