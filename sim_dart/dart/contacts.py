"""Contacts in a world: bodies, points, forces."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from sim_dart.core.arrays import FloatArray


class Contact(NamedTuple):
    """A point where two bodies touch.

    Attributes:
        first, second: Names of the bodies: links, objects, or the ground.
        point: In the world, shape (3,), in [m].
        depth: Penetration depth, in [m].
        force: On the first body, world axes, shape (3,), in [N]; the opposite acts on the second.
    """

    first: str
    second: str
    point: FloatArray
    depth: float
    force: FloatArray


def read_contacts(result: Any, owners: Mapping[Any, str]) -> list[Contact]:
    """Return the contacts that DART has found.

    Args:
        result: A result of collisions.
        owners: Name of the body that each shape of DART belongs to.
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
    """The force of all contacts on each of several bodies, shape (count, 3), world axes, in [N].

    Args:
        result: A result of collisions.
        rows: The row of the body that each shape of DART belongs to, `count` for all others.
        count: Number of the bodies.
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
