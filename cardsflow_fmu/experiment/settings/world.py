"""[world]: ground, objects and contacts around a robot."""

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
    Numbers,
    Positive,
    Short,
    Table,
    Text,
    Vector3,
    setting,
)

ShapeName = Literal["sphere", "box", "capsule", "cylinder", "mesh"]
FrictionLaw = Literal["pyramid", "cone"]
LinkGeometry = Literal["meshes", "capsules", "none"]

NamePair = Annotated[tuple[str, str], Numbers(2, "names")]
Sizes = Annotated[tuple[Positive, Positive, Positive], Numbers(3)]

_ORIGIN = (0.0, 0.0, 0.0)
SIZES: dict[str, tuple[str, ...]] = {
    "sphere": ("radius",),
    "box": ("size",),
    "capsule": ("radius", "length"),
    "cylinder": ("radius", "length"),
    "mesh": ("file", "scale"),
}
"""The keys of each shape."""


def _three(scale: Any) -> Any:
    return scale if isinstance(scale, list | tuple) else [scale] * 3


def _ground(ground: Any) -> Any:
    return ({} if ground else None) if isinstance(ground, bool) else ground


class _Surface(Table):
    """What a body rubs and bounces like."""

    friction: FromZero = setting("that of [world] when left out", None)
    restitution: Fraction = setting("0 for no bounce, 1 for one without loss", None)


class GroundSettings(_Surface):
    """A level floor."""

    height: float = setting("in m", 0.0)


class _Placed(_Surface):
    """A shape in its place."""

    shape: ShapeName = setting("its shape")
    radius: Positive = setting("in m", None)
    length: Positive = setting("of a capsule or cylinder, in m", None)
    size: Sizes = setting("of a box, in m", None)
    file: File = setting("of a mesh, relative to this file", None)
    scale: Annotated[Sizes, Short(_three, {"type": "number"})] = setting("of a mesh", 1.0)
    position: Vector3 = setting("of its middle, in m", _ORIGIN)
    rpy: Vector3 = setting("roll, pitch and yaw, in rad", _ORIGIN)

    @model_validator(mode="after")
    def _check_sizes(self) -> Self:
        others, sizes = self._others, SIZES[self.shape]
        errors: list[InputError] = [
            *self.meaningless(key for key in type(self).model_fields if key not in others),
            *(InputError("missing", key=key) for key in sizes if getattr(self, key) is None),
        ]
        if self.file is not None and not self.file.is_file():
            errors.append(InputError(f"{self.file} is no file", key="file"))
        if errors:
            raise SettingError(*errors)
        return self

    @property
    def _others(self) -> list[str]:
        """The keys of other shapes."""
        own = SIZES[self.shape]
        return [key for keys in SIZES.values() for key in keys if key not in own]

    def data(self, leave_out: Collection[str] = ()) -> dict[str, Any]:
        """As of any table; without a place where it is the origin, and other shapes' keys."""
        nowhere = ["position", "rpy"] if not any((*self.position, *self.rpy)) else []
        return super().data([*leave_out, *nowhere, *self._others])


class ObjectSettings(_Placed):
    """A body beside the robot."""

    name: Text = setting("its name")
    mass: FromZero = setting("in kg; without one it is fixed", 0.0)
    velocity: Vector3 = setting("at the start, in m/s", _ORIGIN)
    angular_velocity: Vector3 = setting("at the start, in rad/s", _ORIGIN)


class LinkShapeSettings(_Placed):
    """A shape that a link collides with beside its meshes."""

    link: Text = setting("of which link")


class WorldSettings(Table):
    """What is around the robot."""

    ground: Annotated[GroundSettings | None, Short(_ground, {"type": "boolean"})] = setting(
        "whether there is a ground", False
    )
    friction: FromZero = setting("of whatever says nothing else", 1.0)
    restitution: Fraction = setting("of whatever says nothing else", 0.0)
    friction_law: FrictionLaw = setting(
        "cone: Coulomb's law; pyramid: up to 41 % too strong between x and y, and faster", "pyramid"
    )
    links: LinkGeometry = setting("what links collide with", "meshes", kind="geometry of links")
    capsule_radius: Positive = setting("where links are capsules, in m", 0.02)
    self_collision: bool = setting("whether links of the robot collide", False)
    ignore: Annotated[tuple[NamePair, ...], Listed] = setting(
        "pairs of names that pass through one another", ()
    )
    contacts: Annotated[tuple[str, ...], Listed] = setting(
        "whose contact forces are outputs; those of all links that collide when left out", None
    )
    objects: Annotated[tuple[ObjectSettings, ...], Listed] = setting("things around the robot", ())
    shapes: Annotated[tuple[LinkShapeSettings, ...], Listed] = setting(
        "what links collide with besides", ()
    )
    sdf: File = setting("an SDF world whose static objects are taken, relative to this file", None)

    def data(self, leave_out: Collection[str] = ()) -> dict[str, Any]:
        """As of any table; whether there is a ground is said in any case."""
        return {"ground": False, **super().data(leave_out)}
