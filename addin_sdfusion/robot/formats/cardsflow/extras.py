"""Reader of robot data that the robot file cannot hold, from its plugin or cardsflow.xml."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import cast

from ...errors import UnknownNameError
from ...finding import Subject
from ...finding_builders import unknown
from ...model.loop import LoopJoint, LoopType
from ...model.muscle import Muscle
from ...model.pose import IDENTITY, Pose, Vector3
from ...model.robot import DEFAULT_SET, MARKERS, Robot
from ..reading.xml import Node, Notes, parse
from .read import MuscleReader, read_surface, read_task_set


def read_extras(robot: Robot, model: Node, plugins: Sequence[Node], cable_set: str | None) -> Robot:
    """Return the robot with its cable sets, task sets, link ends and gravity.

    Args:
        robot: The robot without this data.
        model: Element of the robot.
        plugins: Elements with the data. If they have no cable sets or no task sets, these are read
            from the cardsflow.xml next to the robot file.
        cable_set: Cable set to activate; the default of the file if None.
    """
    cable_sets, task_sets = _children(plugins, "cable_set"), _children(plugins, "task_set")
    sources = [*(() if _are_from_cardsflow_xml(plugins, model) else cardsflow_xml(model)), *plugins]
    robot = _with_mesh_names(_with_ends(robot, plugins), plugins)
    for node in _children(plugins, "gravity"):
        robot = replace(robot, gravity=node.vector3())
    loops = tuple(_loop_joint(node) for node in _children(plugins, "loop_joint"))
    robot = replace(robot, loops=(*robot.loops, *loops))
    surfaces = [
        read_surface(node.named("wrap_surface")) for node in _children(plugins, "wrap_surface")
    ]
    muscles = MuscleReader([link.name for link in robot.links], surfaces)
    if cable_sets:
        robot = _with_named_cable_sets(robot, cable_sets, cable_set, muscles)
        _note_other_muscles(robot, sources)
    else:
        robot = _with_muscles(robot, sources, muscles)
    if cable_set is not None:
        _require_cable_set(cable_set, robot, model)
    robot = replace(robot, wrap_surfaces=tuple(muscles.surfaces))
    if task_sets:
        robot = _with_named_task_sets(robot, task_sets)
        _note_other_points(robot, sources)
        return robot
    return _with_points(robot, sources)


def _children(nodes: Sequence[Node], tag: str) -> list[Node]:
    return [child for node in nodes for child in node.all(tag)]


def _are_from_cardsflow_xml(plugins: Sequence[Node], model: Node) -> bool:
    """Return whether the elements come from the cardsflow.xml next to the robot file."""
    return any(plugin.file != model.file for plugin in plugins)


def cardsflow_xml(model: Node) -> list[Node]:
    """Return the root of the cardsflow.xml next to a robot file; an empty list if none exists."""
    file = model.file.with_name("cardsflow.xml")
    if not file.exists():
        return []
    root = parse(file, model.subject, model.notes)
    if root.tag != "cardsflow":
        root.error("not-cardsflow", f"<{root.tag}> is not <cardsflow>")
    return [root]


def _loop_joint(node: Node) -> LoopJoint:
    name = node.attribute("name")
    node = node.with_subject(Subject("joint", name))
    (parent, T_parent_joint), (child, T_child_joint) = (
        _loop_end(node.required(tag)) for tag in ("parent", "child")
    )
    return LoopJoint(
        name,
        parent,
        child,
        cast(LoopType, node.attribute("type")),  # checked with the robot
        tuple(axis.vector3() for axis in node.all("axis")),
        T_parent_joint,
        T_child_joint,
    )


def _loop_end(node: Node | None) -> tuple[str, Pose]:
    """Return the link at one end of a loop joint, and the pose of its frame in it."""
    if node is None:
        return "", IDENTITY
    x, y, z, roll, pitch, yaw = node.numbers(6)
    return node.attribute("link"), Pose((x, y, z), (roll, pitch, yaw))


def _with_ends(robot: Robot, plugins: Sequence[Node]) -> Robot:
    ends: dict[str, Vector3] = {}
    names = [link.name for link in robot.links]
    known_names = set(names)
    for node in _children(plugins, "link_end"):
        name = node.attribute("link")
        if name not in known_names:
            node.error("unknown-link", f"<link_end>: {unknown('link', name, names)}")
        ends[name] = node.vector3()
    links = tuple(replace(link, end=ends.get(link.name)) for link in robot.links)
    return replace(robot, links=links)


def _with_mesh_names(robot: Robot, plugins: Sequence[Node]) -> Robot:
    """Return the robot with mesh names that SDF cannot hold."""
    names = {
        (node.attribute("link"), node.attribute("role"), node.attribute("as")): node.text
        for node in _children(plugins, "mesh_name")
    }
    links = []
    for link in robot.links:
        meshes = (
            replace(mesh, name=names.get((link.name, mesh.role, mesh.name), mesh.name))
            for mesh in link.meshes
        )
        links.append(replace(link, meshes=tuple(meshes)))
    return replace(robot, links=tuple(links))


def _with_named_cable_sets(
    robot: Robot, nodes: Sequence[Node], chosen: str | None, muscles: MuscleReader
) -> Robot:
    nodes = [node.named("cable_set", "id") for node in nodes]
    active = _active(nodes) if chosen is None else chosen
    sets = tuple(muscles.cable_set(node, node.subject.name, active) for node in nodes)
    return replace(robot, cable_sets=sets, cable_set=active)


def _with_muscles(robot: Robot, sources: Sequence[Node], muscles: MuscleReader) -> Robot:
    """Return the robot with the muscles of the first source that contains muscles."""
    node = _first_source(sources, "myoMuscle")
    if node is None:
        return robot
    cable_set = muscles.cable_set(node, DEFAULT_SET, DEFAULT_SET)
    return replace(robot, cable_sets=(cable_set,), cable_set=DEFAULT_SET)


def _note_other_muscles(robot: Robot, sources: Sequence[Node]) -> None:
    """Report muscles outside cable sets, as Gazebo reads them, that differ from the used ones."""
    node = _first_source(sources, "myoMuscle")
    if node is None:
        return
    reader = MuscleReader([link.name for link in robot.links])
    others = reader.cable_set(replace(node, notes=Notes()), DEFAULT_SET, DEFAULT_SET)
    in_use = {_outline(muscle) for cable_set in robot.cable_sets for muscle in cable_set.muscles}
    differing = [muscle.name for muscle in others.muscles if _outline(muscle) not in in_use]
    _note_ignored(node, "myoMuscle", differing, "cable sets")


def _note_other_points(robot: Robot, sources: Sequence[Node]) -> None:
    """Report points outside task sets, as Gazebo reads them, that differ from the used ones."""
    in_use = {frame for task_set in robot.task_sets for frame in task_set.frames}
    for tag in ("endEffector", "marker"):
        node = _first_source(sources, tag)
        if node is not None:
            others = read_task_set(replace(node, notes=Notes()), DEFAULT_SET, DEFAULT_SET, tag)
            differing = [frame.name for frame in others.frames if frame not in in_use]
            _note_ignored(node, tag, differing, "task sets")


def _note_ignored(node: Node, tag: str, differing: Sequence[str], sets: str) -> None:
    for child in node.all(tag):
        child.mark_used()  # its content was compared
    if differing:
        names = ", ".join(map(repr, differing[:10]))
        problem = f"<{tag}> of {node.file.name} differ from the {sets}, which are used: {names}"
        node.warning("elements-ignored", problem)


def _outline(muscle: Muscle) -> tuple[object, ...]:
    points = tuple((point.link, point.position) for point in muscle.via_points)
    return muscle.name, muscle.f_min, muscle.f_max, points


def _require_cable_set(chosen: str, robot: Robot, model: Node) -> None:
    names = [cable_set.name for cable_set in robot.cable_sets]
    if chosen not in names:
        raise UnknownNameError("cable set", chosen, names, file=model.file)


def _with_named_task_sets(robot: Robot, nodes: Sequence[Node]) -> Robot:
    nodes = [node.named("task_set", "id") for node in nodes]
    active = _active(nodes)
    sets = tuple(read_task_set(node, node.subject.name, active) for node in nodes)
    return replace(robot, task_sets=sets, task_set=active)


def _with_points(robot: Robot, sources: Sequence[Node]) -> Robot:
    """Return the robot with end effectors and markers, each from the first source with any."""
    effectors, markers = (_first_source(sources, tag) for tag in ("endEffector", "marker"))
    sets, active = [], ""
    if effectors is not None:
        active = DEFAULT_SET
        sets.append(read_task_set(effectors, DEFAULT_SET, DEFAULT_SET))
    if markers is not None:
        sets.append(read_task_set(markers, MARKERS, active, "marker"))
    return replace(robot, task_sets=tuple(sets), task_set=active)


def _first_source(sources: Sequence[Node], tag: str) -> Node | None:
    """Return the first source with such elements; report elements that are ignored."""
    matching = [node for node in sources if node.all(tag)]
    for node in matching[1:]:
        problem = f"<{tag}> of {matching[0].file.name} line {matching[0].line} is used, not these"
        node.all(tag)[0].warning("second-source-left-out", problem)
    return matching[0] if matching else None


def _active(nodes: Sequence[Node]) -> str:
    """Return the name of the set that is marked as active; empty if no set is marked."""
    active = [node for node in nodes if node.attribute("active", "false") in ("true", "1")]
    for node in active[1:]:
        node.error("two-active-sets", f"{active[0].subject.name!r} is already active")
    return active[0].subject.name if active else ""
