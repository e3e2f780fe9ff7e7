"""Reading [world], ground, objects and contacts around a robot; and writing it as plain data."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar, cast, get_args

from addin_sdfusion.robot import IDENTITY, InputError, Pose, Robot, Vector3
from addin_sdfusion.robot.readers.sdf.world import StaticObject, read_sdf_world
from cardsflow_fmu.config.table import Table
from cardsflow_fmu.signals.port import signal_names
from sim_dart.dart.link_shapes import link_shapes
from sim_dart.scene import (
    GROUND,
    Box,
    Capsule,
    Cylinder,
    FrictionLaw,
    Ground,
    LinkGeometry,
    LinkShape,
    MeshShape,
    Scene,
    SceneObject,
    Shape,
    Sphere,
)

_KINDS: dict[str, type[Shape]] = {
    "sphere": Sphere,
    "box": Box,
    "capsule": Capsule,
    "cylinder": Cylinder,
    "mesh": MeshShape,
}
_ORIGIN = (0.0, 0.0, 0.0)
_Made = TypeVar("_Made")


def read_world(table: Table, robot: Robot, mesh_folder: Path) -> Scene | None:
    """The scene of [world]; None if the table is absent.

    Args:
        table: The table [world].
        robot: The robot.
        mesh_folder: Where the robot's mesh files stand.

    Raises:
        InputError: Something in it is wrong; the message names file and key.
    """
    if table.is_empty:
        return None
    friction, restitution = table.number("friction", 1.0), table.number("restitution", 0.0)
    objects = [_object(entry) for entry in _tables(table, "objects")]
    ground = _ground(table)
    if "sdf" in table:
        static, height = _sdf(table)
        objects += static
        if height is not None and "ground" not in table:
            ground = Ground(height)
    table.value("sdf", None)
    law = table.choice("friction_law", "friction law", get_args(FrictionLaw), "pyramid")
    links = table.choice("links", "geometry of links", get_args(LinkGeometry), "meshes")
    scene = _made(
        table,
        "friction",
        lambda: Scene(
            ground,
            tuple(objects),
            friction,
            restitution,
            cast(FrictionLaw, law),
            cast(LinkGeometry, links),
            table.positive("capsule_radius", 0.02),
            tuple(_link_shape(entry) for entry in _tables(table, "shapes")),
            mesh_folder,
            table.flag("self_collision", False),
        ),
    )
    return _with_names(table, scene, robot)


def _with_names(table: Table, scene: Scene, robot: Robot) -> Scene:
    """The scene with what it says of bodies by their names, which must exist."""
    for shape in scene.link_shapes:
        known = [link.name for link in robot.links]
        if shape.link not in known:
            raise table.unknown("shapes", "link", shape.link, known)
    links = list(dict.fromkeys(shape.link for shape in link_shapes(robot, scene)))
    things = [thing.name for thing in scene.objects]
    bodies = [*links, *things, *([GROUND] if scene.ground else [])]
    taken: set[str] = set()
    for name in [*(link.name for link in robot.links), GROUND, *things]:
        if name in taken:
            raise table.error("objects", f"the name {name!r} is taken; rename the object")
        taken.add(name)
    ignored = tuple(_pair(table, pair, bodies) for pair in table.value("ignore", []))
    reported = table.value("contacts", links)
    if not isinstance(reported, list | tuple):
        raise table.error("contacts", f"must be a list of names, not {reported!r}")
    for name in reported:
        if name not in bodies:
            raise table.unknown("contacts", "link or object that collides", str(name), bodies)
    table.close()
    try:
        signal_names("object", [thing.name for thing in scene.moving_objects])
        signal_names("contact", reported)
    except InputError as error:
        raise table.error("contacts", error.what) from None
    return replace(scene, ignored=ignored, reported=tuple(reported))


def _pair(table: Table, pair: Any, bodies: Sequence[str]) -> tuple[str, str]:
    if not isinstance(pair, list | tuple) or len(pair) != 2:
        raise table.error("ignore", f"must be a list of pairs of names, not {pair!r}")
    for name in pair:
        if name not in bodies:
            raise table.unknown("ignore", "link or object that collides", str(name), bodies)
    return pair[0], pair[1]


def _ground(table: Table) -> Ground | None:
    value = table.value("ground", False)
    if isinstance(value, bool):
        return Ground() if value else None
    inner = table.table("ground")
    ground = _made(inner, "height", lambda: Ground(inner.number("height", 0.0), *_surface(inner)))
    inner.close()
    return ground


def _object(table: Table) -> SceneObject:
    made = _made(
        table,
        "mass",
        lambda: SceneObject(
            table.text("name"),
            _shape(table),
            _pose(table),
            table.number("mass", 0.0),
            _vector(table, "velocity"),
            _vector(table, "spin"),
            *_surface(table),
        ),
    )
    table.close()
    return made


def _link_shape(table: Table) -> LinkShape:
    made = _made(
        table,
        "shape",
        lambda: LinkShape(table.text("link"), _shape(table), _pose(table), *_surface(table)),
    )
    table.close()
    return made


def _shape(table: Table) -> Shape:
    kind = table.choice("shape", "shape", list(_KINDS))
    if kind == "sphere":
        return Sphere(table.positive("radius"))
    if kind == "box":
        x, y, z = table.numbers("size", 3)
        return _made(table, "size", lambda: Box((x, y, z)))
    if kind in ("capsule", "cylinder"):
        form = Capsule if kind == "capsule" else Cylinder
        return form(table.positive("radius"), table.positive("length"))
    file = table.file.parent / table.text("file")
    if not file.is_file():
        raise table.error("file", f"{file} is no file")
    return _made(table, "scale", lambda: MeshShape(file, _scale(table)))


def _scale(table: Table) -> Vector3:
    value = table.value("scale", 1.0)
    if isinstance(value, list | tuple):
        x, y, z = table.numbers("scale", 3)
        return x, y, z
    factor = table.number("scale", 1.0)
    return factor, factor, factor


def _pose(table: Table) -> Pose:
    return Pose(_vector(table, "position"), _vector(table, "rpy"))


def _vector(table: Table, key: str) -> Vector3:
    x, y, z = table.numbers(key, 3, _ORIGIN)
    return x, y, z


def _surface(table: Table) -> tuple[float | None, float | None]:
    values = []
    for key in ("friction", "restitution"):
        values.append(table.number(key) if key in table else None)
        table.value(key, None)
    return values[0], values[1]


def _tables(table: Table, key: str) -> Iterator[Table]:
    """A list of tables, each under its own key."""
    rows = table.value(key, [])
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise table.error(key, f"must be a list of tables, not {rows!r}")
    for k, row in enumerate(rows):
        yield table.element(key, k, row)


def _made(table: Table, key: str, make: Callable[[], _Made]) -> _Made:
    """What a record's constructor makes of numbers; its complaints get file and key."""
    try:
        return make()
    except InputError as error:
        if error.file is not None:
            raise
        raise table.error(key, error.what) from None


def _sdf(table: Table) -> tuple[list[SceneObject], float | None]:
    """The static objects of an SDF world."""
    world = read_sdf_world(table.file.parent / table.text("sdf"))
    for finding in world.findings:
        if finding.is_error:
            raise InputError(finding.message, file=finding.file, line=finding.line)
    return [_static(table, each) for each in world.objects], world.ground


def _static(table: Table, thing: StaticObject) -> SceneObject:
    x = thing.sizes
    shapes: dict[str, Callable[[], Shape]] = {
        "sphere": lambda: Sphere(x[0]),
        "box": lambda: Box((x[0], x[1], x[2])),
        "capsule": lambda: Capsule(x[0], x[1]),
        "cylinder": lambda: Cylinder(x[0], x[1]),
        "mesh": lambda: MeshShape(cast(Path, thing.file), (x[0], x[1], x[2])),
    }
    return _made(
        table,
        "sdf",
        lambda: SceneObject(
            thing.name,
            shapes[thing.kind](),
            thing.pose,
            friction=thing.friction,
            restitution=thing.restitution,
        ),
    )


def world_data(scene: Scene) -> dict[str, Any]:
    """What [world] says of a scene, complete: it reads back as the same.

    Args:
        scene: The scene; files of meshes are written with their paths as they are.
    """
    return {
        "ground": False
        if scene.ground is None
        else {"height": scene.ground.height} | _surface_data(scene.ground),
        "friction": scene.friction,
        "restitution": scene.restitution,
        "friction_law": scene.friction_law,
        "links": scene.links,
        "capsule_radius": scene.capsule_radius,
        "self_collision": scene.self_collision,
        "ignore": [list(pair) for pair in scene.ignored],
        "contacts": list(scene.reported),
        "objects": [
            {
                "name": thing.name,
                "mass": thing.mass,
                "velocity": list(thing.velocity),
                "spin": list(thing.spin),
            }
            | _placed_data(thing)
            for thing in scene.objects
        ],
        "shapes": [{"link": shape.link} | _placed_data(shape) for shape in scene.link_shapes],
    }


def _placed_data(thing: SceneObject | LinkShape) -> dict[str, Any]:
    return (
        _shape_data(thing.shape)
        | ({} if thing.pose == IDENTITY else _pose_data(thing.pose))
        | _surface_data(thing)
    )


def _pose_data(pose: Pose) -> dict[str, Any]:
    return {"position": list(pose.position), "rpy": list(pose.rpy)}


def _shape_data(shape: Shape) -> dict[str, Any]:
    kind = next(name for name, form in _KINDS.items() if isinstance(shape, form))
    if isinstance(shape, MeshShape):
        return {"shape": kind, "file": str(shape.file), "scale": list(shape.scale)}
    if isinstance(shape, Box):
        return {"shape": kind, "size": list(shape.size)}
    if isinstance(shape, Sphere):
        return {"shape": kind, "radius": shape.radius}
    return {"shape": kind, "radius": shape.radius, "length": shape.length}


def _surface_data(thing: SceneObject | LinkShape | Ground) -> dict[str, Any]:
    pairs = (("friction", thing.friction), ("restitution", thing.restitution))
    return {key: value for key, value in pairs if value is not None}
