"""The scene of an experiment: what [world] says, complete, with its bodies and their names."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from addin_sdfusion.robot import InputError, Pose, Robot, UnknownNameError
from addin_sdfusion.robot.readers.sdf.world import StaticObject, read_sdf_world
from cardsflow_fmu.signals.port import signal_names
from sim_dart.dart.link_shapes import link_shapes
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
_Made = TypeVar("_Made")


def make_scene(
    settings: WorldSettings, robot: Robot, mesh_folder: Path, file: Path
) -> tuple[Scene, WorldSettings]:
    """The scene of [world], and the table complete: with an SDF world's objects, and all names.

    Args:
        settings: The table.
        robot: The robot.
        mesh_folder: Where the robot's mesh files are.
        file: The experiment, for messages.

    Raises:
        InputError: Something in it is wrong; the message names file and key.
    """
    if settings.sdf is not None:
        settings = _with_sdf(settings, settings.sdf, file)
    ground = settings.ground
    scene = Scene(
        None if ground is None else Ground(ground.height, ground.friction, ground.restitution),
        tuple(
            _made(file, f"objects[{k}].mass", partial(_object, own))
            for k, own in enumerate(settings.objects)
        ),
        settings.friction,
        settings.restitution,
        settings.friction_law,
        settings.links,
        settings.capsule_radius,
        tuple(
            _made(file, f"shapes[{k}].shape", partial(_link_shape, own))
            for k, own in enumerate(settings.shapes)
        ),
        mesh_folder,
        settings.self_collision,
        settings.ignore,
    )
    contacts = _checked_names(settings, scene, robot, file)
    return replace(scene, reported=contacts), settings.replaced(contacts=contacts)


def _object(own: ObjectSettings) -> SceneObject:
    return SceneObject(
        own.name,
        _shape(own),
        Pose(own.position, own.rpy),
        own.mass,
        own.velocity,
        own.spin,
        own.friction,
        own.restitution,
    )


def _link_shape(own: LinkShapeSettings) -> LinkShape:
    pose = Pose(own.position, own.rpy)
    return LinkShape(own.link, _shape(own), pose, own.friction, own.restitution)


def _shape(own: ObjectSettings | LinkShapeSettings) -> Shape:
    sizes: Any = (getattr(own, key) for key in SIZES[own.shape])
    return _SHAPES[own.shape](*sizes)


def _made(file: Path, key: str, make: Callable[[], _Made]) -> _Made:
    """What a record's constructor makes of numbers; its complaints get file and key."""
    try:
        return make()
    except InputError as error:
        raise InputError(error.what, file=file, key=f"world.{key}") from None


def _with_sdf(settings: WorldSettings, sdf: Path, file: Path) -> WorldSettings:
    """The table with the static objects of an SDF world."""
    world = read_sdf_world(sdf)
    for finding in world.findings:
        if finding.is_error:
            raise InputError(finding.message, file=finding.file, line=finding.line)
    static = [_made(file, "sdf", partial(_static, own)) for own in world.objects]
    settings = settings.replaced(objects=(*settings.objects, *static), sdf=None)
    if world.ground is None or "ground" in settings.model_fields_set:
        return settings
    return settings.replaced(ground=GroundSettings(height=world.ground))


def _static(thing: StaticObject) -> ObjectSettings:
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


def _checked_names(
    settings: WorldSettings, scene: Scene, robot: Robot, file: Path
) -> tuple[str, ...]:
    """The names of bodies whose contacts are reported; all names in the table must exist."""

    def require(name: str, known: Sequence[str], key: str, kind: str) -> None:
        if name not in known:
            raise UnknownNameError(kind, name, known, file=file, key=f"world.{key}")

    for shape in scene.link_shapes:
        require(shape.link, [link.name for link in robot.links], "shapes", "link")
    links = list(dict.fromkeys(shape.link for shape in link_shapes(robot, scene)))
    things = [thing.name for thing in scene.objects]
    bodies = [*links, *things, *([GROUND] if scene.ground else [])]
    taken: set[str] = set()
    for name in [*(link.name for link in robot.links), GROUND, *things]:
        if name in taken:
            what = f"the name {name!r} is taken; rename the object"
            raise InputError(what, file=file, key="world.objects")
        taken.add(name)
    contacts = tuple(links) if settings.contacts is None else settings.contacts
    for pair in settings.ignore:
        for name in pair:
            require(name, bodies, "ignore", "link or object that collides")
    for name in contacts:
        require(name, bodies, "contacts", "link or object that collides")
    try:
        signal_names("object", [thing.name for thing in scene.moving_objects])
        signal_names("contact", contacts)
    except InputError as error:
        raise InputError(error.what, file=file, key="world.contacts") from None
    return contacts
