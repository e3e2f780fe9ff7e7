"""Rotation of designs whose y axis points up to z up, without rounding."""

from __future__ import annotations

from array import array
from dataclasses import replace

from ..robot.model.pose import Vector3
from ..snapshot import DesignSnapshot, JointSnapshot, MassSnapshot, MeshSnapshot


def upright(snapshot: DesignSnapshot) -> DesignSnapshot:
    """Return the design with z up; a design with z up is returned unchanged."""
    if snapshot.settings.up_axis == "z":
        return snapshot
    return replace(
        snapshot,
        occurrences=tuple(replace(o, mass=_mass(o.mass)) for o in snapshot.occurrences),
        bodies=tuple(replace(b, mass=_mass(b.mass), mesh=_mesh(b.mesh)) for b in snapshot.bodies),
        joints=tuple(map(_joint, snapshot.joints)),
        points=tuple(replace(p, position=_rotate(p.position)) for p in snapshot.points),
        surfaces=tuple(
            replace(s, centre=_rotate(s.centre), axis=_rotate(s.axis)) for s in snapshot.surfaces
        ),
    )


def _rotate(v: Vector3) -> Vector3:
    """Return a vector rotated by 90° about x, which moves y to z."""
    x, y, z = v
    return x, 0.0 - z, y


def _mass(mass: MassSnapshot | None) -> MassSnapshot | None:
    if mass is None:
        return None
    xx, yy, zz, xy, yz, xz = mass.moments
    moments = (xx, zz, yy, 0.0 - xz, 0.0 - yz, xy)
    return replace(mass, com=_rotate(mass.com), moments=moments)


def _mesh(mesh: MeshSnapshot | None) -> MeshSnapshot | None:
    if mesh is None:
        return None
    nodes = array("d", mesh.nodes)
    nodes[1::3] = array("d", [0.0 - z for z in mesh.nodes[2::3]])
    nodes[2::3] = mesh.nodes[1::3]
    return replace(mesh, nodes=nodes)


def _joint(joint: JointSnapshot) -> JointSnapshot:
    return replace(
        joint,
        origin_one=None if joint.origin_one is None else _rotate(joint.origin_one),
        origin_two=None if joint.origin_two is None else _rotate(joint.origin_two),
        motions=tuple(replace(m, axis=_rotate(m.axis)) for m in joint.motions),
    )
