"""Reader of SDF models and the cardsflow.xml next to them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Literal, cast

from ...finding import Subject
from ...model.joint import Coordinate, Joint
from ...model.loop import LoopJoint, loop_type
from ...model.pose import IDENTITY, Pose
from ...model.robot import SHAPE_SIZES, Inertia, Link, Mesh, Rgba, Robot, Shape, ShapeKind
from ...model.rotations import compose, inverse, rotate_inertia, rotation
from ...transforms.repair import diagnose
from ...transforms.repair import repair as repair_inertias
from ..cardsflow.extras import cardsflow_xml, read_extras
from ..reading.chains import join_chains
from ..reading.meshes import note_missing_meshes
from ..reading.tree import fixed_roots, parents_first
from ..reading.unique_names import with_unique_names
from ..reading.xml import TRUE, Node, Notes, parse, short_repr
from .read_frames import Frames, read_pose
from .read_joints import Model, read_joint
from .read_nested import flatten, included_models

_WORDS = ("limits", "damping", "stiffness", "friction")
VERSIONS = tuple(f"1.{minor}" for minor in range(4, 13))


def read_sdf(
    file: Path, cable_set: str | None, notes: Notes, *, repair: bool = False
) -> Robot | None:
    """Return the robot in an SDF file with one model.

    Muscles are read from the cable sets of the plugin or of the cardsflow.xml next to the file, as
    written by `write_sdf`. If neither has cable sets, muscles directly in these elements are read.

    Args:
        file: The SDF file.
        cable_set: Cable set to activate; the default of the file if None.
        notes: Collects findings, locations and files.
        repair: Whether to repair known inertia errors.

    Raises:
        InputError: A file is not readable XML.
        UnknownNameError: The cable set does not exist.
    """
    root = parse(file, Subject("robot", file.stem), notes)
    node = _model(root)
    if node is None:
        return None
    node = node.with_subject(Subject("robot", node.attribute("name")))
    for kind in ("link", "joint"):
        with_unique_names(node.all(kind), partial(Subject, kind))
    frames = Frames(node)
    model = Model(frames, _model_pose(node, frames), root.attribute("version", ""))
    joints, loops = _split_loops([_about(child, "joint") for child in node.all("joint")], model)
    roots = fixed_roots(
        node.all("link"),
        joints,
        lambda name: compose(model.T_world_model, frames.in_model(("link", name))),
        node,
    )
    plugins = _extras(node)
    joints, inner = join_chains(joints, plugins)
    links = [_read_link(_about(child, "link"), frames) for child in node.all("link")]
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


def _about(node: Node, kind: str) -> Node:
    return node.with_subject(Subject(kind, node.attribute("name")))


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


def _split_loops(nodes: Sequence[Node], model: Model) -> tuple[list[Joint], list[LoopJoint]]:
    """Return the joints of the tree and the loop joints.

    If several joints have the same child, the first one in the file is the tree joint. A joint
    with range 0 is the tree joint only if no other joint exists. A loop joint with range 0 becomes
    fixed.

    Args:
        nodes: Elements of the joints.
        model: Data of the model.
    """
    read = [(read_joint(node, model), node) for node in nodes]
    carriers: dict[str, Joint] = {}
    for joint, _ in sorted(read, key=lambda item: _has_zero_range(item[0])):
        if joint.parent != joint.child:
            carriers.setdefault(joint.child, joint)
    loops = [
        _loop(joint, node, carriers[joint.child])
        for joint, node in read
        if carriers.get(joint.child, joint) is not joint
    ]
    names = {id(joint) for joint in carriers.values()}
    return [j for j, _ in read if id(j) in names or j.child not in carriers], loops


def _has_zero_range(joint: Joint) -> bool:
    """Return whether a joint has motions, all with the range 0 to 0."""
    return bool(joint.motions) and all(c.lower == c.upper == 0.0 for c in joint.coordinates)


def _loop(joint: Joint, node: Node, carrier: Joint) -> LoopJoint:
    motions = joint.motions
    if _has_zero_range(joint):
        motions = ()
        problem = f"closes a loop, since {carrier.name!r} already moves {joint.child!r}"
        node.warning("loop-joint-held", f"{problem}; its range is 0, so it is read as fixed")
    lost = [what for what in _WORDS if any(_has_property(c, what) for c in joint.coordinates)]
    if motions and lost:
        problem = f"closes a loop, so it has no coordinates; its {', '.join(lost)} are omitted"
        node.warning("loop-joint-forces", problem)
    kind = loop_type(motions)
    assert kind is not None, joint.name  # all joint types of SDF can close loops
    return LoopJoint(
        joint.name, joint.parent, joint.child, *kind, joint.T_parent_joint, joint.T_child_joint
    )


def _has_property(c: Coordinate, what: str) -> bool:
    if what == "limits":
        return math.isfinite(c.lower) or math.isfinite(c.upper)
    return bool(getattr(c, what))


def _read_link(node: Node, frames: Frames) -> Link:
    """Return a link; report features that a robot description cannot hold."""
    name = node.subject.name
    gravity = node.optional("gravity")
    if gravity is not None and gravity.text in ("false", "0"):
        gravity.warning("gravity-not-off", "<gravity> is ignored; gravity acts on the link")
    kinematic = node.optional("kinematic")
    if kinematic is not None and kinematic.text in TRUE:
        kinematic.warning("kinematic-link", "<kinematic> is ignored; forces move the link")
    meshes, shapes = tuple(_meshes(node, frames)), tuple(_shapes(node, frames))
    inertial = node.optional("inertial")
    if inertial is None:
        problem = "has no <inertial>; SDF's defaults 1 kg and 1 kg·m² are used"
        node.warning("default-inertial", problem)
        return Link(name, Inertia(1.0, ixx=1.0, iyy=1.0, izz=1.0), meshes=meshes, shapes=shapes)
    if inertial.attribute("auto", "false") in TRUE:
        problem = "inertia from collision shapes is not supported; specify it explicitly"
        inertial.error("unsupported-inertial", problem)
    if inertial.all("fluid_added_mass"):
        inertial.warning("added-mass-not-simulated", "fluid added mass is not simulated")
    return Link(
        name, _inertia(inertial, frames.in_link(inertial, name)), meshes=meshes, shapes=shapes
    )


def _inertia(inertial: Node, pose: Pose) -> Inertia:
    mass = inertial.number("mass")
    node = inertial.required("inertia")
    if node is None:
        return Inertia(mass, pose.position)
    moments = {entry: node.number(entry) for entry in ("ixx", "iyy", "izz")}
    products = {entry: node.number(entry, 0.0) for entry in ("ixy", "ixz", "iyz")}
    inertia = Inertia(mass, pose.position, **moments, **products)
    if not any(pose.rpy):
        return inertia
    matrix = rotate_inertia(rotation(pose.rpy), inertia.matrix)
    return Inertia.of(mass, pose.position, matrix)


def _meshes(link: Node, frames: Frames) -> Iterator[Mesh]:
    for node in link.all("visual", "collision"):
        geometry = node.required("geometry")
        if geometry is None:
            continue
        for shape in geometry.all():
            if shape.tag == "mesh":
                yield _mesh(node, shape, frames)
            elif shape.tag != "empty" and not _is_kept(node, shape):
                kept = "meshes" if node.tag == "visual" else "meshes, boxes, spheres and cylinders"
                problem = (
                    f"a {node.tag} of {short_repr(shape.tag)} is omitted; only {kept} are read"
                )
                shape.warning("geometry-left-out", problem)


def _is_kept(node: Node, shape: Node) -> bool:
    return node.tag == "collision" and shape.tag in SHAPE_SIZES


def _shapes(link: Node, frames: Frames) -> Iterator[Shape]:
    for node in link.all("collision"):
        for geometry in node.all("geometry"):
            for shape in geometry.all(*SHAPE_SIZES):
                pose = frames.in_link(node, node.subject.name)
                yield Shape(cast(ShapeKind, shape.tag), _sizes(shape), pose)


def _sizes(shape: Node) -> tuple[float, ...]:
    if shape.tag == "box":
        return shape.vector("size")
    return tuple(shape.number(n) for n in ("radius", "length")[: SHAPE_SIZES[shape.tag]])  # type: ignore[index]


def _mesh(node: Node, shape: Node, frames: Frames) -> Mesh:
    uri, scale = shape.required("uri"), shape.optional("scale")
    if shape.all("submesh"):
        shape.warning("submesh-left-out", "the whole mesh is used instead of the submesh")
    return Mesh(
        cast(Literal["visual", "collision"], node.tag),
        "" if uri is None else uri.text,
        frames.in_link(node, node.subject.name),
        (1.0, 1.0, 1.0) if scale is None else scale.vector3(),
        node.attribute("name", ""),
        _color(node),
    )


def _color(visual: Node) -> Rgba | None:
    """Return the diffuse colour; the opacity is 1 if not specified."""
    material = visual.optional("material") if visual.tag == "visual" else None
    diffuse = None if material is None else material.optional("diffuse")
    if diffuse is None:
        return None
    red, green, blue, *opacity = diffuse.numbers(3 if len(diffuse.text.split()) == 3 else 4)
    return red, green, blue, opacity[0] if opacity else 1.0
