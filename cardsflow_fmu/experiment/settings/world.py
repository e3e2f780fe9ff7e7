"""Settings of [world]: ground, objects and contacts."""

from __future__ import annotations

from collections.abc import Collection
from typing import Annotated, Any, Literal, Self

from pydantic import model_validator

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.config.messages import SettingError
from cardsflow_fmu.experiment.config.table import (
    File,
    Fraction,
    FromZero,
    Listed,
    Positive,
    ShortForm,
    Table,
    Text,
    Vector3,
    list_of,
    setting,
)
from sim_dart.scene import FrictionLaw, LinkGeometry

ShapeName = Literal["sphere", "box", "capsule", "cylinder", "mesh"]

NamePair = Annotated[tuple[str, str], list_of(2, "names")]
Sizes = Annotated[tuple[Positive, Positive, Positive], list_of(3)]

_ORIGIN = (0.0, 0.0, 0.0)
SIZES: dict[str, tuple[str, ...]] = {
    "sphere": ("radius",),
    "box": ("size",),
    "capsule": ("radius", "length"),
    "cylinder": ("radius", "length"),
    "mesh": ("file", "scale"),
}
"""Keys of each shape."""


def _per_axis(scale: Any) -> Any:
    return scale if isinstance(scale, list | tuple) else [scale] * 3


def _ground(ground: Any) -> Any:
    return ({} if ground else None) if isinstance(ground, bool) else ground


class _Surface(Table):
    """Friction and restitution of a body."""

    friction: FromZero = setting("friction coefficient (default: world.friction)", None)
    restitution: Fraction = setting(
        "coefficient of restitution, from 0 to 1 (default: world.restitution)", None
    )


class GroundSettings(_Surface):
    """Horizontal ground plane."""

    height: float = setting("height of the ground, in m", 0.0)


class _ShapeWithPose(_Surface):
    """Shape with a pose."""

    shape: ShapeName = setting("kind of shape")
    radius: Positive = setting("radius, in m", None)
    length: Positive = setting("length of a capsule or cylinder, in m", None)
    size: Sizes = setting("edge lengths of a box, in m", None)
    file: File = setting("file of a mesh, relative to this file", None)
    scale: Annotated[Sizes, ShortForm(_per_axis, {"type": "number"})] = setting(
        "scale of a mesh: one factor, or one per axis", 1.0
    )
    position: Vector3 = setting("position of the centre, in m", _ORIGIN)
    rpy: Vector3 = setting("roll, pitch and yaw, in rad", _ORIGIN)

    @model_validator(mode="after")
    def _check_sizes(self) -> Self:
        others, sizes = self._others, SIZES[self.shape]
        errors: list[InputError] = [
            *self.inapplicable_keys(key for key in type(self).model_fields if key not in others),
            *(InputError("missing", key=key) for key in sizes if getattr(self, key) is None),
        ]
        if self.file is not None and not self.file.is_file():
            errors.append(InputError(f"{self.file} does not exist", key="file"))
        if errors:
            raise SettingError(*errors)
        return self

    @property
    def _others(self) -> list[str]:
        """Keys of other shapes."""
        keys_of_shape = SIZES[self.shape]
        return [key for keys in SIZES.values() for key in keys if key not in keys_of_shape]

    def data(self, leave_out: Collection[str] = ()) -> dict[str, Any]:
        """Return the table as plain data, without a pose at the origin and keys of other shapes."""
        pose_keys = ["position", "rpy"] if not any((*self.position, *self.rpy)) else []
        return super().data([*leave_out, *pose_keys, *self._others])


class ObjectSettings(_ShapeWithPose):
    """Free or fixed body in the world."""

    name: Text = setting("name of the object")
    mass: FromZero = setting("mass, in kg; 0 for a fixed object", 0.0)
    velocity: Vector3 = setting("initial velocity, in m/s", _ORIGIN)
    angular_velocity: Vector3 = setting("initial angular velocity, in rad/s", _ORIGIN)


class LinkShapeSettings(_ShapeWithPose):
    """Additional collision shape of a link."""

    link: Text = setting("link that has the shape")


class WorldSettings(Table):
    """Ground, objects and contacts."""

    ground: Annotated[GroundSettings | None, ShortForm(_ground, {"type": "boolean"})] = setting(
        "ground: true, false, or a table", False
    )
    friction: FromZero = setting("default friction coefficient of bodies", 1.0)
    restitution: Fraction = setting("default coefficient of restitution of bodies", 0.0)
    friction_law: FrictionLaw = setting(
        "cone: Coulomb friction; pyramid: faster, but up to 41 % too strong between x and y",
        "pyramid",
    )
    links: LinkGeometry = setting(
        "collision shapes of the links", "meshes", kind="geometry of links"
    )
    capsule_radius: Positive = setting("radius of link capsules, in m", 0.02)
    self_collision: bool = setting("detect collisions between links of the robot", False)
    ignore: Annotated[tuple[NamePair, ...], Listed] = setting(
        "pairs of bodies that do not collide", ()
    )
    contacts: Annotated[tuple[str, ...], Listed] = setting(
        "links whose contact forces are outputs (default: all links that collide)", None
    )
    objects: Annotated[tuple[ObjectSettings, ...], Listed] = setting("objects around the robot", ())
    shapes: Annotated[tuple[LinkShapeSettings, ...], Listed] = setting(
        "additional collision shapes of links", ()
    )
    sdf: File = setting("SDF world whose static objects are added, relative to this file", None)

    def data(self, leave_out: Collection[str] = ()) -> dict[str, Any]:
        """Return the table as plain data; `ground` is always included."""
        return {"ground": False, **super().data(leave_out)}
