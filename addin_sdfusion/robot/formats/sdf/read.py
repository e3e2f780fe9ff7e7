"""Reader of an SDF model and the cardsflow.xml next to it."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

from ...finding import Subject
from ...model.pose import IDENTITY, Pose
from ...model.robot import Robot
from ...model.rotations import compose, inverse
from ...transforms.repair import diagnose
from ...transforms.repair import repair as repair_inertias
from ..cardsflow.beside import cardsflow_xml, read_extras
from ..reading.chains import join_chains
from ..reading.distinct import distinct
from ..reading.meshes import note_missing_meshes
from ..reading.tree import parents_first, welds
from ..reading.xml import TRUE, Node, Notes, parse, shortened
from .read_frames import Frames, read_pose
from .read_joints import Model
from .read_links import read_link
from .read_loops import split_loops
from .read_nested import flatten, included_models

VERSIONS = tuple(f"1.{minor}" for minor in range(4, 13))


def read_sdf(
    file: Path, cable_set: str | None, notes: Notes, *, repair: bool = False
) -> Robot | None:
    """Return the robot in an SDF file with one model.

    Muscles come from the cable sets of the plugin, or of the cardsflow.xml next to the file, as
    `write_sdf` makes them; without those, from muscles in these directly.

    Args:
        file: The SDF file.
        cable_set: The cable set to make active; the file's own choice if None.
        notes: Where findings, places and files go.
        repair: Whether to repair known inertia errors.

    Raises:
        InputError: A file is not readable XML.
        UnknownNameError: There is no such cable set.
    """
    root = parse(file, Subject("robot", file.stem), notes)
    node = _model(root)
    if node is None:
        return None
    node = node.about(Subject("robot", node.attribute("name")))
    for kind in ("link", "joint"):
        distinct(node.all(kind), partial(Subject, kind))
    frames = Frames(node)
    model = Model(frames, _placed(node, frames), root.attribute("version", ""))
    joints, loops = split_loops([_about(child, "joint") for child in node.all("joint")], model)
    roots = welds(
        node.all("link"),
        joints,
        lambda name: compose(model.T_world_model, frames.in_model(("link", name))),
        node,
    )
    plugins = _extras(node)
    joints, inner = join_chains(joints, plugins)
    links = [read_link(_about(child, "link"), frames) for child in node.all("link")]
    links = [link for link in links if link.name not in inner]
    note_missing_meshes(node, links)
    ordered = tuple(parents_first([*roots, *joints]))
    robot = Robot(node.subject.name, tuple(links), ordered, loops=tuple(loops))
    robot = _diagnosed(robot, frames, node, undo=repair)
    return read_extras(robot, node, plugins, cable_set)


def _extras(node: Node) -> list[Node]:
    """What holds the words that SDF lacks: our plugin, or a cardsflow.xml and others' plugins."""
    plugins = node.all("plugin")
    is_ours = any(plugin.all("gravity") for plugin in plugins)
    return plugins if is_ours else [*cardsflow_xml(node), *plugins]


def _about(node: Node, kind: str) -> Node:
    return node.about(Subject(kind, node.attribute("name")))


def _model(root: Node) -> Node | None:
    """Return the one model of a file, directly or in a world."""
    if root.tag != "sdf":
        root.error("not-sdf", f"<{root.tag}> is not <sdf>")
        return None
    if root.attribute("version") not in VERSIONS:
        version = shortened(root.attribute("version", ""))
        root.warning("sdf-version", f"SDF {version} is read as SDF {VERSIONS[-1]}")
    places = [root, *root.all("world")]
    models = [node for place in places for node in place.all("model")]
    models += [node for place in places for node in included_models(place)]
    if len(models) != 1:
        names = ", ".join(repr(node.attribute("name", "")) for node in models[:10]) or "none"
        at = models[1] if models else root
        at.error("not-one-model", f"the file holds {len(models)} models ({names}); give one each")
        return None
    flatten(models[0])
    static = models[0].optional("static")
    if static is not None and static.text in TRUE:
        static.warning("static-model", "<static> is ignored; the joints of the model can move")
    return models[0]


def _placed(model: Node, frames: Frames) -> Pose:
    """T_world_model: the pose of the model, or of the frame in it that the pose is for."""
    pose = model.optional("pose")
    T_world_frame = IDENTITY if pose is None else read_pose(pose)
    if pose is not None and pose.attribute("relative_to", "") not in ("", "world"):
        pose.error("unknown-frame", "the pose of a model can be relative to the world only")
    name = model.attribute("placement_frame", "")
    key = frames.named(name)
    if key is None:
        problem = f"placement_frame {shortened(name)}: no link, joint or frame of the name"
        model.error("unknown-frame", problem)
        return T_world_frame
    return compose(T_world_frame, inverse(frames.in_model(key)))


def _diagnosed(robot: Robot, frames: Frames, model: Node, *, undo: bool) -> Robot:
    """The robot, with its inertias repaired if asked for; what is wrong with them is noted."""
    poses = [frames.in_model(("link", link.name)) for link in robot.links]
    diagnosis = diagnose(robot.links, poses)
    if diagnosis is None:
        return robot
    findings = diagnosis.findings(model.subject)
    if undo:
        robot, findings = repair_inertias(robot, diagnosis)
    notes = model.notes
    for finding in findings:
        file, line = notes.locations.get(finding.subject, (model.file, None))
        notes.findings.append(replace(finding, file=file, line=line))
    return robot
