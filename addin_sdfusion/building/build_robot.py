"""Conversion of a design snapshot to a robot, with all findings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ..muscles.design_table import read_table
from ..muscles.table import MuscleTable
from ..report import sort_findings
from ..robot.finding import Finding, Subject
from ..robot.finding_builders import error, warning
from ..robot.model.joint import Joint
from ..robot.model.pose import Pose
from ..robot.model.robot import Link, Robot
from ..robot.transforms.part_map import PartMap
from ..snapshot import BodySnapshot, DesignSnapshot, bare_name
from ..snapshot.mass_properties import link_inertia
from .design_checks import (
    body_findings,
    design_notes,
    massless_links,
    name_findings,
    point_findings,
    snapshot_findings,
    up_hint,
)
from .joints.couplings import add_couplings
from .joints.edges import Edges, find_edges, grounded_links, pinned_links
from .joints.reversal import reverse_coordinates
from .links.links import Links, find_links, is_link_group
from .links.masses import Masses, compute_masses
from .overrides import override_joint_settings, override_masses
from .robot_findings import add_robot_findings
from .robot_muscles import CABLE_SET, TASK_SET, RobotMuscles, robot_muscles
from .tree.link_frames import Frames, place_links
from .tree.loop_joints import Loops, loop_joints
from .tree.tree import Graph, Tree, find_tree
from .upright import upright


@dataclass(frozen=True)
class BuiltRobot:
    """A robot that was built from a design.

    Poses and bodies are in the world frame. It is the root frame of the design, rotated by 90°
    about x if the y axis of the design points up.

    Attributes:
        robot: The robot without meshes; None if a finding is an error.
        findings: Findings on the design and the robot, errors first.
        T_world_link: Pose of every link of the tree, at the pose of the design.
        link_of_occurrence: Link of each occurrence, by its name in the design, as returned by
            `link_of`; the other attributes contain the exported names.
        base: Link at the root of the tree, by its name in the design; empty if it does not exist.
        loops: Joint names of every closed loop; it can be cut at each of them.
    """

    robot: Robot | None
    findings: tuple[Finding, ...]
    T_world_link: Mapping[str, Pose] = field(default_factory=dict)
    bodies_of_link: Mapping[str, tuple[BodySnapshot, ...]] = field(default_factory=dict)
    link_of_occurrence: Mapping[str, str] = field(default_factory=dict)
    base: str = ""
    loops: tuple[tuple[str, ...], ...] = ()


def build_robot(snapshot: DesignSnapshot) -> BuiltRobot:
    """Build a robot from a design.

    The result does not depend on the order of anything in the snapshot.
    """
    wrong = snapshot_findings(snapshot)
    if not wrong:
        building = _RobotBuilder(reverse_coordinates(upright(snapshot)))
        if building.has_links:
            return building.build()
        wrong = building.findings
    return BuiltRobot(None, sort_findings([*snapshot.findings, *wrong]))


def check_design(snapshot: DesignSnapshot) -> list[Finding]:
    """Return the findings on a design and its robot, errors first."""
    return list(build_robot(snapshot).findings)


def link_of(snapshot: DesignSnapshot) -> Mapping[str, str]:
    """Return the link of each occurrence that belongs to a link, by the path of the occurrence.

    The empty path refers to the bodies of the root component.

    Args:
        snapshot: The design. If components are links, the root component is a link if it has
            bodies.
    """
    return find_links(snapshot).of_occurrence


def moving_robot(snapshot: DesignSnapshot) -> tuple[Robot | None, str]:
    """Return the links and joints of a design, for motion only.

    The world frame is the root frame of the design. The robot has no muscles, and its masses are
    not valid if the snapshot has none.

    Returns:
        The robot, or None if the joints are invalid; and the first error on the joints, or an
        empty string.
    """
    wrong = snapshot_findings(snapshot)
    if not wrong:
        building = _RobotBuilder(reverse_coordinates(snapshot))
        if building.has_links:
            return building.build_moving()
        wrong = building.findings
    errors = [finding.message for finding in wrong if finding.is_error]
    return None, errors[0] if errors else "The design has no links."


class _RobotBuilder:
    """Builder of one robot from a design with z up."""

    def __init__(self, snapshot: DesignSnapshot) -> None:
        self._snapshot = snapshot
        self.findings: list[Finding] = list(snapshot.findings)
        all_links = find_links(snapshot)
        self.findings += all_links.findings
        edges = find_edges(snapshot, all_links)
        self.findings += edges.findings
        self._links = self._without_empty_links(all_links, edges)
        masses: Masses = compute_masses(snapshot, self._links)
        parts, unset = override_masses(masses.parts, snapshot.settings)
        self._masses = masses._replace(parts=parts)
        self.findings += unset
        self._tree: Tree = self._find_tree(edges)
        self._frames: Frames = place_links(self._tree.branches)
        self._loops: Loops = loop_joints(self._tree.closings, self._frames.T_world_link)

    @property
    def has_links(self) -> bool:
        """Whether the design has links."""
        return bool(self._links.names)

    def build(self) -> BuiltRobot:
        """Return the robot with all findings."""
        snapshot, links, masses = self._snapshot, self._links, self._masses
        table, findings = read_table(snapshot, links.of_occurrence)
        muscles = self._muscles(table)
        joints, uncoupled = add_couplings(self._frames.joints, snapshot.couplings)
        joints, unset = override_joint_settings(joints, snapshot.settings)
        robot = self._robot(muscles, joints)
        base = self._tree.branches[0].child if self._tree.branches else ""
        self.findings += [
            *uncoupled,
            *unset,
            *masses.findings,
            *self._tree.findings,
            *self._loops.findings,
            *body_findings(snapshot, links),
            *findings,
            *muscles.findings,
            *point_findings(snapshot, table),
            *name_findings(robot),
            *design_notes(snapshot, robot),
            *up_hint(snapshot, masses.parts, base),
        ]
        massless = massless_links(links.names, masses.parts)
        all_findings = sort_findings(add_robot_findings(self.findings, massless, robot))
        names = {each.link: each.exported_name for each in snapshot.settings.of_links}
        renamed = PartMap(link=lambda link: names.get(link, link)).apply_to(robot)
        return BuiltRobot(
            None if any(f.is_error for f in all_findings) else renamed,
            all_findings,
            {names.get(k, k): T.pose() for k, T in self._frames.T_world_link.items()},
            {names.get(k, k): bodies for k, bodies in masses.bodies.items()},
            links.of_occurrence,
            base,
            self._tree.loops,
        )

    def build_moving(self) -> tuple[Robot | None, str]:
        """Return the robot without muscles, or None and the first error on the joints."""
        joints, uncoupled = add_couplings(self._frames.joints, self._snapshot.couplings)
        joints, unset = override_joint_settings(joints, self._snapshot.settings)
        findings = [*self.findings, *self._tree.findings, *self._loops.findings, *uncoupled, *unset]
        for finding in findings:
            if finding.is_error:
                return None, finding.message
        return self._robot(RobotMuscles((), (), (), ()), joints), ""

    def _without_empty_links(self, links: Links, edges: Edges) -> Links:
        """Return the links that have bodies, joints or mass; report the others."""
        if links.from_groups or self._snapshot.settings.components:
            return links
        of = links.of_occurrence
        used = {link for edge in (*edges.joints, *edges.cut) for link in edge.links}
        used |= {of[body.occurrence] for body in self._snapshot.bodies if body.occurrence in of}
        used |= {of[o.path] for o in self._snapshot.occurrences if o.mass and o.path in of}
        empty = [name for name in links.names if name not in used]
        for name in empty:
            problem = "has no bodies and no joints and is not exported; add some or delete it"
            self.findings.append(warning(Subject("link", name), "empty-component", problem))
        if empty and len(empty) == len(links.names):
            problem = "nothing to export: no component has a body"
            subject = Subject("design", self._snapshot.name)
            self.findings.append(error(subject, "nothing-to-export", problem))
        return links.without(empty)

    def _find_tree(self, edges: Edges) -> Tree:
        snapshot, links = self._snapshot, self._links
        grounding = [e for e in edges.grounding if all(link in links.names for link in e.links)]
        grounded = [n for n in grounded_links(snapshot, links) if n in links.names]
        pinned = pinned_links(snapshot, links)
        graph = Graph(links.names, edges.joints, grounding, edges.cut, grounded, pinned)
        return find_tree(graph, snapshot.settings, snapshot.name)

    def _muscles(self, table: MuscleTable) -> RobotMuscles:
        groups = self._snapshot.groups
        suppressed = {
            bare_name(group.name) for group in groups if group.suppressed and is_link_group(group)
        }
        return robot_muscles(table, self._frames.T_world_link, suppressed)

    def _robot(self, muscles: RobotMuscles, joints: tuple[Joint, ...]) -> Robot:
        poses = self._frames.T_world_link
        names = [set_.name for set_ in muscles.task_sets]
        return Robot(
            self._snapshot.settings.name or self._snapshot.name,
            tuple(
                Link(link, link_inertia(self._masses.parts[link], T)) for link, T in poses.items()
            ),
            joints,
            muscles.cable_sets,
            CABLE_SET if muscles.cable_sets else "",
            muscles.task_sets,
            TASK_SET if TASK_SET in names else "",
            wrap_surfaces=muscles.surfaces,
            loops=self._loops.joints,
        )
