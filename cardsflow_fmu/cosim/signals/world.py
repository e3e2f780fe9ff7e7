"""Plant variables of the surroundings: contact forces, objects, wrenches on links; see `ports`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from .port import Causality, Port, signal_names

if TYPE_CHECKING:
    from sim_dart.scene import Scene

FRICTION_ERROR, FRICTION_NOT_CONVERGED = "friction_error", "friction_not_converged"
_QUATERNION = ("qw", "qx", "qy", "qz")


def wrench_signals(links: Sequence[str]) -> list[str]:
    """Return `w.<link>.fx`, ..., `w.<link>.tz` of every link with an external wrench."""
    axes = [f"{kind}{axis}" for kind in "ft" for axis in "xyz"]
    return [f"{name}.{axis}" for name in signal_names("w", links) for axis in axes]


def wrench_ports(links: Sequence[str], causality: Causality) -> list[Port]:
    """Return the ports of external forces and torques on links."""
    ports = []
    for name in wrench_signals(links):
        is_force = name[-2] == "f"
        meaning = f"External {'force' if is_force else 'torque'} on link {name[2:-3]}, world axes"
        ports.append(Port(name, "N" if is_force else "N.m", causality, "continuous", meaning))
    return ports


def object_signals(scene: Scene) -> list[str]:
    """Return `object.<name>.x`, ..., `.qz` of every moving object."""
    names = signal_names("object", [item.name for item in scene.moving_objects])
    return [f"{name}.{axis}" for name in names for axis in (*"xyz", *_QUATERNION)]


def world_ports(scene: Scene | None) -> list[Port]:
    """Return contact forces and poses of objects as outputs."""
    if scene is None:
        return []
    ports = [
        Port(name, "N", "output", "continuous", f"Contact force on {name[8:-3]}, world axes")
        for body in signal_names("contact", scene.reported)
        for name in (f"{body}.f{axis}" for axis in "xyz")
    ]
    for name in object_signals(scene):
        body, _, axis = name.removeprefix("object.").rpartition(".")
        is_rotation = axis in _QUATERNION
        meaning = f"{'Unit quaternion' if is_rotation else 'Position'} of {body}"
        unit, bound = ("", 1.0) if is_rotation else ("m", math.inf)
        ports.append(Port(name, unit, "output", "continuous", meaning, lower=-bound, upper=bound))
    return [*ports, *_friction_ports(scene)]


def _friction_ports(scene: Scene) -> list[Port]:
    """Return the error of the friction solver, if the solver reports it."""
    if scene.friction_law != "cone":
        return []
    error = "Largest speed by which a contact violates Coulomb's law since the last step"
    undecided = "Whether contact forces did not converge since the last step"
    return [
        Port(FRICTION_ERROR, "m/s", "output", "discrete", error, lower=0.0),
        Port(FRICTION_NOT_CONVERGED, "", "output", "discrete", undecided, boolean=True),
    ]
