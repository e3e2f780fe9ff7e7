"""Conversion of a design snapshot to a robot, with all findings."""

from __future__ import annotations

from array import array
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from ..muscles.design_table import read_table
from ..muscles.table import MuscleTable
from ..report import sort_findings
from ..robot.finding import Finding, Subject
from ..robot.finding_builders import error, warning
from ..robot.model.joint import Joint
from ..robot.model.muscle import Muscle, ViaPoint, Wrap
from ..robot.model.pose import Pose, Vector3
from ..robot.model.robot import Link, Robot
from ..snapshot import (
    BodySnapshot,
    CouplingSnapshot,
    DesignSnapshot,
    JointSnapshot,
    MassSnapshot,
    MeshSnapshot,
    MotionSnapshot,
    bare_name,
)
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
from .joints.checks import coordinate_name
from .joints.couplings import add_couplings, coupled_name
from .joints.edges import Edges, find_edges, grounded_links, pinned_links
from .links.links import Links, find_links, is_link_group
from .links.masses import Masses, compute_masses
from .overrides import override_joint_settings, override_masses
from .robot_findings import add_robot_findings
from .robot_muscles import CABLE_SET, TASK_SET, RobotMuscles, robot_muscles
from .tree.link_frames import Frames, place_links
from .tree.loop_joints import Loops, loop_joints
from .tree.tree import Graph, Tree, find_tree


@dataclass(frozen=True)
class BuiltRobot:
    """A robot that was built from a design.

    Poses and bodies are in the world frame. It is the root frame of the design, rotated by 90°
    about x if the y axis of the design points up.

    Attributes:
        robot: The robot without meshes; None if a finding is an error.
        findings: Findings on the design and the robot, errors first.
        T_world_link: Pose of every link of the tree, at the pose of the design.
        bodies_of_link: The bodies of every link.
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
        building = _RobotBuilder(_reverse_coordinates(_upright(snapshot)))
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
        building = _RobotBuilder(_reverse_coordinates(snapshot))
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
        found = sort_findings(add_robot_findings(self.findings, massless, robot))
        names = {each.link: each.exported_name for each in snapshot.settings.of_links}
        return BuiltRobot(
            None if any(finding.is_error for finding in found) else _rename_links(robot, names),
            found,
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
        found = [*self.findings, *self._tree.findings, *self._loops.findings, *uncoupled, *unset]
        for finding in found:
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
        held = [e for e in edges.held if all(link in links.names for link in e.links)]
        grounded = [n for n in grounded_links(snapshot, links) if n in links.names]
        pinned = pinned_links(snapshot, links)
        graph = Graph(links.names, edges.joints, held, edges.cut, grounded, pinned)
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


def _upright(snapshot: DesignSnapshot) -> DesignSnapshot:
    """Return the design with z up; a design with z up is returned unchanged."""
    if snapshot.settings.up_axis == "z":
        return snapshot
    return replace(
        snapshot,
        occurrences=tuple(replace(o, mass=_mass(o.mass)) for o in snapshot.occurrences),
        bodies=tuple(replace(b, mass=_mass(b.mass), mesh=_mesh(b.mesh)) for b in snapshot.bodies),
        joints=tuple(map(_joint, snapshot.joints)),
        points=tuple(replace(p, position=_rotate(p.position)) for p in snapshot.points),
        surfaces=tuple(
            replace(s, centre=_rotate(s.centre), axis=_rotate(s.axis)) for s in snapshot.surfaces
        ),
    )


def _rotate(v: Vector3) -> Vector3:
    """Return a vector rotated by 90° about x, which moves y to z."""
    x, y, z = v
    return x, 0.0 - z, y


def _mass(mass: MassSnapshot | None) -> MassSnapshot | None:
    if mass is None:
        return None
    xx, yy, zz, xy, yz, xz = mass.moments
    moments = (xx, zz, yy, 0.0 - xz, 0.0 - yz, xy)
    return replace(mass, com=_rotate(mass.com), moments=moments)


def _mesh(mesh: MeshSnapshot | None) -> MeshSnapshot | None:
    if mesh is None:
        return None
    nodes = array("d", mesh.nodes)
    nodes[1::3] = array("d", [0.0 - z for z in mesh.nodes[2::3]])
    nodes[2::3] = mesh.nodes[1::3]
    return replace(mesh, nodes=nodes)


def _joint(joint: JointSnapshot) -> JointSnapshot:
    return replace(
        joint,
        origin_one=None if joint.origin_one is None else _rotate(joint.origin_one),
        origin_two=None if joint.origin_two is None else _rotate(joint.origin_two),
        motions=tuple(replace(m, axis=_rotate(m.axis)) for m in joint.motions),
    )


def _reverse_coordinates(snapshot: DesignSnapshot) -> DesignSnapshot:
    """Return the design with the coordinates that its settings reverse.

    The motion of the parts is unchanged: axis, value, limits and couplings change their signs.
    """
    names = {chosen.joint for chosen in snapshot.settings.of_joints if chosen.reversed}
    if not names:
        return snapshot
    return replace(
        snapshot,
        joints=tuple(_with_reversed_motions(joint, names) for joint in snapshot.joints),
        couplings=tuple(_coupling(coupling, names) for coupling in snapshot.couplings),
    )


def _with_reversed_motions(joint: JointSnapshot, names: set[str]) -> JointSnapshot:
    name, count = bare_name(joint.name), len(joint.motions)
    motions = (
        _reversed(m) if coordinate_name(name, m, count) in names else m for m in joint.motions
    )
    return replace(joint, motions=tuple(motions))


def _reversed(motion: MotionSnapshot) -> MotionSnapshot:
    x, y, z = motion.axis
    return replace(
        motion,
        axis=(0.0 - x, 0.0 - y, 0.0 - z),
        value=0.0 - motion.value,
        lower=None if motion.upper is None else 0.0 - motion.upper,
        upper=None if motion.lower is None else 0.0 - motion.lower,
        rest=0.0 - motion.rest,
    )


def _coupling(c: CouplingSnapshot, names: set[str]) -> CouplingSnapshot:
    follower, leader = (
        -1.0 if coupled_name(joint, role) in names else 1.0
        for joint, role in ((c.follower, c.follower_role), (c.leader, c.leader_role))
    )
    return replace(c, ratio=follower * leader * c.ratio, offset=follower * c.offset + 0.0)


def _rename_links(robot: Robot, names: Mapping[str, str]) -> Robot:
    """Return the robot with other names of links.

    Args:
        robot: The robot.
        names: New names by old names; other links keep their names.
    """

    def named(link: str) -> str:
        return names.get(link, link)

    def point(via: ViaPoint) -> ViaPoint:
        return replace(via, link=named(via.link))

    def wrap(given: Wrap) -> Wrap:
        return replace(given, side_point=given.side_point and point(given.side_point))

    def muscle(given: Muscle) -> Muscle:
        points = tuple(map(point, given.via_points))
        return replace(given, via_points=points, wraps=tuple(map(wrap, given.wraps)))

    return replace(
        robot,
        links=tuple(replace(link, name=named(link.name)) for link in robot.links),
        joints=tuple(
            replace(j, parent=named(j.parent), child=named(j.child)) for j in robot.joints
        ),
        loops=tuple(
            replace(loop, parent=named(loop.parent), child=named(loop.child))
            for loop in robot.loops
        ),
        wrap_surfaces=tuple(replace(s, link=named(s.link)) for s in robot.wrap_surfaces),
        cable_sets=tuple(
            replace(group, muscles=tuple(map(muscle, group.muscles))) for group in robot.cable_sets
        ),
        task_sets=tuple(
            replace(group, frames=tuple(replace(f, link=named(f.link)) for f in group.frames))
            for group in robot.task_sets
        ),
    )
