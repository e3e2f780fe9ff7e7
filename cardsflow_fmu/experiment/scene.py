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
        for k, own in enumerate(getattr(settings, key)):
            if own.file is not None:
                require_packable(own.file, roots, f"world.{key}[{k}].file")
    ground, objects, link_shapes = settings.ground, [], []
    for k, own in enumerate(settings.objects):
        with context.at(f"world.objects[{k}]"):
            objects.append(_object(own))
    for k, shape in enumerate(settings.shapes):
        pose = Pose(shape.position, shape.rpy)
        surface = shape.friction, shape.restitution
        with context.at(f"world.shapes[{k}]"):
            link_shapes.append(LinkShape(shape.link, _shape(shape), pose, *surface))
    with context.at("world"):
        scene = Scene(
            None if ground is None else Ground(ground.height, ground.friction, ground.restitution),
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


def _object(own: ObjectSettings) -> SceneObject:
    return SceneObject(
        own.name,
        _shape(own),
        Pose(own.position, own.rpy),
        own.mass,
        own.velocity,
        own.angular_velocity,
        own.friction,
        own.restitution,
    )


def _shape(own: ObjectSettings | LinkShapeSettings) -> Shape:
    sizes: Any = (getattr(own, key) for key in SIZES[own.shape])
    return _SHAPES[own.shape](*sizes)


def _with_sdf(
    settings: WorldSettings, sdf: Path, context: Context
) -> tuple[WorldSettings, tuple[Finding, ...]]:
    """Return the table with the static objects of an SDF world, and warnings about the file."""
    world = read_sdf_world(sdf)
    for finding in world.findings:
        if finding.is_error:
            raise InputError(finding.message, file=finding.file, line=finding.line)
    with context.at("world.sdf"):
        static = [_static_object(own) for own in world.objects]
    settings = settings.copy_with(objects=(*settings.objects, *static), sdf=None)
    if world.ground is None or "ground" in settings.model_fields_set:
        return settings, world.findings
    ground = GroundSettings(height=world.ground)
    return settings.copy_with(ground=ground), world.findings


def _static_object(thing: StaticObject) -> ObjectSettings:
    x = thing.sizes
    sizes: dict[str, Any] = {
        "sphere": {"radius": x[0]},
        "box": {"size": x},
        "capsule": {"radius": x[0], "length": x[-1]},
        "cylinder": {"radius": x[0], "length": x[-1]},
        "mesh": {"file": thing.file, "scale": x},
    }
    own: dict[str, Any] = {
        "name": thing.name,
        "shape": thing.kind,
        "position": thing.pose.position,
        "rpy": thing.pose.rpy,
        "friction": thing.friction,
        "restitution": thing.restitution,
        **sizes[thing.kind],
    }
    return ObjectSettings(**{key: value for key, value in own.items() if value is not None})


def _check_names(
    settings: WorldSettings, scene: Scene, robot: Robot, context: Context
) -> tuple[str, ...]:
    """Return the names of bodies with reported contacts; check all names of the table."""
    kind, own = "link or object that collides", [link.name for link in robot.links]
    for shape in scene.link_shapes:
        context.require("world.shapes", "link", shape.link, own)
    links = list(dict.fromkeys(shape.link for shape in collision_shapes(robot, scene)))
    things = [thing.name for thing in scene.objects]
    bodies = [*links, *things, *([GROUND] if scene.ground else [])]
    taken: set[str] = set()
    for name in [*own, GROUND, *things]:
        if name in taken:
            raise context.error(
                "world.objects", f"the name {name!r} is already used; rename the object"
            )
        taken.add(name)
    contacts = tuple(links) if settings.contacts is None else settings.contacts
    for pair in settings.ignore:
        for name in pair:
            context.require("world.ignore", kind, name, bodies)
    for name in contacts:
        context.require("world.contacts", kind, name, bodies)
    with context.at("world.contacts"):
        signal_names("object", [thing.name for thing in scene.moving_objects])
        signal_names("contact", contacts)
    return contacts
