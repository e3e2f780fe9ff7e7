"""Contacts in a world: bodies, points and forces."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from sim_dart.core.arrays import FloatArray


class Contact(NamedTuple):
    """Contact point of two bodies.

    Attributes:
        first, second: Names of the bodies: links, objects, or the ground.
        point: Position in the world frame, shape (3,), in [m].
        depth: Penetration depth, in [m].
        force: Force on the first body, world axes, shape (3,), in [N]. The opposite force acts on
            the second body.
    """

    first: str
    second: str
    point: FloatArray
    depth: float
    force: FloatArray


def read_contacts(result: Any, owners: Mapping[Any, str]) -> list[Contact]:
    """Return the contacts of a collision result of DART.

    Args:
        result: Collision result of DART.
        owners: Name of the body of each shape node of DART.
    """
    return [
        Contact(
            owners[contact.collisionObject1.getShapeFrame()],
            owners[contact.collisionObject2.getShapeFrame()],
            np.array(contact.point),
            float(contact.penetrationDepth),
            np.array(contact.force),
        )
        for contact in result.getContacts()
    ]


def contact_forces(result: Any, rows: Mapping[Any, int], count: int) -> FloatArray:
    """Return the sum of contact forces on each body, world axes, shape (count, 3), in [N].

    Args:
        result: Collision result of DART.
        rows: Row of the body of each shape node of DART, `count` for all other bodies.
    """
    contacts = result.getContacts()
    forces = np.zeros((count + 1, 3))
    if contacts:
        first = [rows[c.collisionObject1.getShapeFrame()] for c in contacts]
        second = [rows[c.collisionObject2.getShapeFrame()] for c in contacts]
        each = np.array([c.force for c in contacts])
        np.add.at(forces, first, each)
        np.subtract.at(forces, second, each)
    return forces[:-1]
