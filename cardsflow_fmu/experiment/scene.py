"""Scene of an experiment, from the table [world]."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import Finding, InputError, Pose, Robot
from addin_sdfusion.robot.formats.sdf.world import StaticObject, read_sdf_world
from cardsflow_fmu.cosim.signals.port import signal_names
from cardsflow_fmu.experiment.config.table import Context
from sim_dart.dart.link_shapes import link_shapes as collision_shapes
from sim_dart.scene import (
    GROUND,
    Box,
    Capsule,
    Cylinder,
    Ground,
    LinkShape,
    MeshShape,
    Scene,
    SceneObject,
    Shape,
    Sphere,
)

from .packed_files import require_packable
from .settings.world import (
    SIZES,
    GroundSettings,
    LinkShapeSettings,
    ObjectSettings,
    WorldSettings,
)

_SHAPES: dict[str, type[Shape]] = {
    "sphere": Sphere,
    "box": Box,
    "capsule": Capsule,
    "cylinder": Cylinder,
    "mesh": MeshShape,
}


def make_scene(
    settings: WorldSettings,
    robot: Robot,
    mesh_folder: Path,
    roots: tuple[Path, ...],
    context: Context,
) -> tuple[Scene, WorldSettings, tuple[Finding, ...]]:
    """Return the scene of [world], the table with SDF objects and all contact names, and findings.

    The findings are warnings about content of the SDF world that is not read.
    """
    findings: tuple[Finding, ...] = ()
    if settings.sdf is not None:
        roots = (*roots, settings.sdf.parent)
        settings, findings = _with_sdf(settings, settings.sdf, context)
    for key in ("objects", "shapes"):
        for k, row in enumerate(getattr(settings, key)):
            if row.file is not None:
                require_packable(row.file, roots, f"world.{key}[{k}].file")
    ground, objects, link_shapes = settings.ground, [], []
    for k, row in enumerate(settings.objects):
        with context.at(f"world.objects[{k}]"):
            objects.append(_object(row))
    for k, shape in enumerate(settings.shapes):
        pose = Pose(shape.position, shape.rpy)
        surface = shape.friction, shape.restitution
        with context.at(f"world.shapes[{k}]"):
            link_shapes.append(LinkShape(shape.link, _shape(shape), pose, *surface))
    with context.at("world"):
        scene = Scene(
            None if ground is None else Ground(**dict(ground)),
            tuple(objects),
            settings.friction,
            settings.restitution,
            settings.friction_law,
            settings.links,
            settings.capsule_radius,
            tuple(link_shapes),
            mesh_folder,
            roots,
            settings.self_collision,
            settings.ignore,
        )
    contacts = _check_names(settings, scene, robot, context)
    return replace(scene, reported=contacts), settings.copy_with(contacts=contacts), findings


def _object(settings: ObjectSettings) -> SceneObject:
    keys = {"name", "mass", "velocity", "angular_velocity", "friction", "restitution"}
    pose = Pose(settings.position, settings.rpy)
    return SceneObject(shape=_shape(settings), pose=pose, **settings.model_dump(include=keys))


def _shape(settings: ObjectSettings | LinkShapeSettings) -> Shape:
    sizes: Any = (getattr(settings, key) for key in SIZES[settings.shape])
    return _SHAPES[settings.shape](*sizes)


def _with_sdf(
    settings: WorldSettings, sdf: Path, context: Context
) -> tuple[WorldSettings, tuple[Finding, ...]]:
    """Return the table with the static objects of an SDF world, and warnings about the file."""
    world = read_sdf_world(sdf)
    for finding in world.findings:
        if finding.is_error:
            raise InputError(finding.message, file=finding.file, line=finding.line)
    with context.at("world.sdf"):
        static = [_static_object(item) for item in world.objects]
    settings = settings.copy_with(objects=(*settings.objects, *static), sdf=None)
    if world.ground is None or "ground" in settings.model_fields_set:
        return settings, world.findings
    ground = GroundSettings(height=world.ground)
    return settings.copy_with(ground=ground), world.findings


def _static_object(item: StaticObject) -> ObjectSettings:
    x = item.sizes
    sizes: dict[str, Any] = {
        "sphere": {"radius": x[0]},
        "box": {"size": x},
        "capsule": {"radius": x[0], "length": x[-1]},
        "cylinder": {"radius": x[0], "length": x[-1]},
        "mesh": {"file": item.file, "scale": x},
    }
    values: dict[str, Any] = {
        "name": item.name,
        "shape": item.kind,
        "position": item.pose.position,
        "rpy": item.pose.rpy,
        "friction": item.friction,
        "restitution": item.restitution,
        **sizes[item.kind],
    }
    return ObjectSettings(**{key: value for key, value in values.items() if value is not None})


def _check_names(
    settings: WorldSettings, scene: Scene, robot: Robot, context: Context
) -> tuple[str, ...]:
    """Return the names of bodies with reported contacts; check all names of the table."""
    kind, link_names = "link or object that collides", [link.name for link in robot.links]
    for shape in scene.link_shapes:
        context.require("world.shapes", "link", shape.link, link_names)
    links = list(dict.fromkeys(shape.link for shape in collision_shapes(robot, scene)))
    object_names = [item.name for item in scene.objects]
    bodies = [*links, *object_names, *([GROUND] if scene.ground else [])]
    used: set[str] = set()
    for name in [*link_names, GROUND, *object_names]:
        if name in used:
            raise context.error(
                "world.objects", f"the name {name!r} is already used; rename the object"
            )
        used.add(name)
    contacts = tuple(links) if settings.contacts is None else settings.contacts
    for pair in settings.ignore:
        for name in pair:
            context.require("world.ignore", kind, name, bodies)
    for name in contacts:
        context.require("world.contacts", kind, name, bodies)
    with context.at("world.contacts"):
        signal_names("object", [item.name for item in scene.moving_objects])
        signal_names("contact", contacts)
    return contacts
