"""Joint types of CASPR: names, motions and coordinates."""

from __future__ import annotations

from typing import NamedTuple

from ...model import pose
from ...model.joint import Motion, MotionKind

AXES = dict(zip("xyz", pose.AXES, strict=True))
ANGLES = {"x": "alpha", "y": "beta", "z": "gamma"}


class CasprJoint(NamedTuple):
    """Joint type of CASPR.

    Attributes:
        motions: Motions from the parent to the child.
        suffixes: Suffixes of the coordinate names, in the order of q in CASPR.
    """

    motions: tuple[Motion, ...]
    suffixes: tuple[str, ...]


def _joint(translations: str, rotations: str, order: str | None = None) -> CasprJoint:
    """Return a joint type of translations and then rotations, each given by its axis letter.

    Args:
        rotations: Axes of the rotations, from the parent to the child.
        order: Order of the rotations in q, if different.
    """
    names = order or rotations
    motions = [Motion("translation", AXES[axis], k) for k, axis in enumerate(translations)]
    motions += [
        Motion("rotation", AXES[axis], len(translations) + names.index(axis)) for axis in rotations
    ]
    single = len(motions) == 1
    suffixes = ("",) if single else (*translations, *(ANGLES[axis] for axis in names))
    return CasprJoint(tuple(motions), suffixes)


CASPR_JOINTS: dict[str, CasprJoint] = {
    "R_X": _joint("", "x"),
    "R_Y": _joint("", "y"),
    "R_Z": _joint("", "z"),
    "U_XY": _joint("", "xy"),
    "U_YZ": _joint("", "yz"),
    "U_XZ": _joint("", "xz"),
    "P_X": _joint("x", ""),
    "P_XY": _joint("xy", ""),
    "P_XZ": _joint("xz", ""),
    "T_XYZ": _joint("xyz", ""),
    "PLANAR_XY": _joint("xy", "z"),
    "PLANAR_YZ": _joint("yz", "x"),
    "PLANAR_XZ": _joint("xz", "y"),
    "S_EULER_XYZ": _joint("", "xyz"),
    "S_FIXED_XYZ": _joint("", "zyx", order="xyz"),
    "SPATIAL_EULER_XYZ": _joint("xyz", "xyz"),
}
"""Joint types with fixed axes, by their name in CASPR."""

CASPR_AXIS_JOINTS: dict[str, MotionKind] = {"R_AXIS": "rotation", "P_AXIS": "translation"}
"""Joint types whose axis is defined in the file, and the kind of their motion."""


def caspr_joint_type(motions: tuple[Motion, ...]) -> str | None:
    """Return CASPR's name of the joint type with these motions, or None if none exists."""
    for word, joint in CASPR_JOINTS.items():
        if joint.motions == motions:
            return word
    for word, kind in CASPR_AXIS_JOINTS.items():
        if len(motions) == 1 and motions[0].kind == kind:
            return word
    return None
