"""Reader of SDF models and the cardsflow.xml next to them."""

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
from ..cardsflow.extras import cardsflow_xml, read_extras
from ..reading.chains import join_chains
from ..reading.meshes import note_missing_meshes
from ..reading.tree import fixed_roots, parents_first
from ..reading.unique_names import with_unique_names
from ..reading.xml import TRUE, Node, Notes, parse, short_repr
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

    Muscles are read from the cable sets of the plugin or of the cardsflow.xml next to the file, as
    written by `write_sdf`. If neither has cable sets, muscles directly in these elements are read.

    Args:
        cable_set: Cable set to activate; the default of the file if None.
        notes: Collects findings, locations and files.
        repair: Whether to repair known inertia errors.
    """
    root = parse(file, Subject("robot", file.stem), notes)
    node = _model(root)
    if node is None:
        return None
    node = node.named("robot")
    for kind in ("link", "joint"):
        with_unique_names(node.all(kind), partial(Subject, kind))
    frames = Frames(node)
    model = Model(frames, _model_pose(node, frames), root.attribute("version", ""))
    joints, loops = split_loops([child.named("joint") for child in node.all("joint")], model)
    roots = fixed_roots(
        node.all("link"),
        joints,
        lambda name: compose(model.T_world_model, frames.in_model(("link", name))),
        node,
    )
    plugins = _extras(node)
    joints, inner = join_chains(joints, plugins)
    links = [read_link(child.named("link"), frames) for child in node.all("link")]
    links = [link for link in links if link.name not in inner]
    note_missing_meshes(node, links)
    ordered = tuple(parents_first([*roots, *joints]))
    robot = Robot(node.subject.name, tuple(links), ordered, loops=tuple(loops))
    robot = _with_diagnosis(robot, frames, node, undo=repair)
    return read_extras(robot, node, plugins, cable_set)


def _extras(node: Node) -> list[Node]:
    """Return our plugin, or the cardsflow.xml and other plugins, with data SDF cannot hold."""
    plugins = node.all("plugin")
    is_ours = any(plugin.all("gravity") for plugin in plugins)
    return plugins if is_ours else [*cardsflow_xml(node), *plugins]


def _model(root: Node) -> Node | None:
    """Return the only model of a file, which may be inside a world."""
    if root.tag != "sdf":
        root.error("not-sdf", f"<{root.tag}> is not <sdf>")
        return None
    if root.attribute("version") not in VERSIONS:
        version = short_repr(root.attribute("version", ""))
        root.warning("sdf-version", f"unsupported version {version}; read as SDF {VERSIONS[-1]}")
    places = [root, *root.all("world")]
    models = [node for place in places for node in place.all("model")]
    models += [node for place in places for node in included_models(place)]
    if len(models) != 1:
        names = ", ".join(repr(node.attribute("name", "")) for node in models[:10]) or "none"
        at = models[1] if models else root
        at.error("not-one-model", f"contains {len(models)} models ({names}); use a file per model")
        return None
    flatten(models[0])
    static = models[0].optional("static")
    if static is not None and static.text in TRUE:
        static.warning("static-model", "<static> is ignored; the joints of the model can move")
    return models[0]


def _model_pose(model: Node, frames: Frames) -> Pose:
    """Return T_world_model, the pose of the model or of its placement frame."""
    pose = model.optional("pose")
    T_world_frame = IDENTITY if pose is None else read_pose(pose)
    if pose is not None and pose.attribute("relative_to", "") not in ("", "world"):
        pose.error("unknown-frame", "the pose of a model must be relative to the world")
    name = model.attribute("placement_frame", "")
    key = frames.named(name)
    if key is None:
        problem = f"placement_frame {short_repr(name)} does not exist as link, joint or frame"
        model.error("unknown-frame", problem)
        return T_world_frame
    return compose(T_world_frame, inverse(frames.in_model(key)))


def _with_diagnosis(robot: Robot, frames: Frames, model: Node, *, undo: bool) -> Robot:
    """Return the robot, with repaired inertias if requested; report inertia errors."""
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
