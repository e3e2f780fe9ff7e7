"""Mapping between CASPR's names and ours: cables, pulleys, operational spaces, trajectories."""

from __future__ import annotations

from typing import Literal, NamedTuple

from .model.muscle import CableKind
from .model.robot import Axis
from .model.trajectory import Spline


class Property(NamedTuple):
    """A number, or a row of numbers, of a CASPR element.

    Attributes:
        tag: Name of the XML element.
        size: Number of values, or None for any number.
        required: Whether CASPR requires the property.
    """

    tag: str
    size: int | None = 1
    required: bool = True

    def name(self, index: int) -> str:
        """Return the name of the cable parameter for a value; `index` counts from 1."""
        return self.tag if self.size == 1 else f"{self.tag}_{index}"


class CasprCable(NamedTuple):
    """A cable element.

    Attributes:
        kind: Our name for this kind of cable.
        properties: Properties, except the force limits. Each number of a row becomes a separate
            parameter: `<tag>_1`, `<tag>_2`, ...
    """

    kind: CableKind
    properties: tuple[Property, ...]


class CasprPulley(NamedTuple):
    """An attachment element that describes a pulley at the base.

    Attributes:
        kind: Our name for this kind of pulley.
        location: Name of the XML element with the point where the cable enters the pulley.
        properties: All other properties.
    """

    kind: Literal["rotating", "screw"]
    location: str
    properties: tuple[Property, ...]


_OTHER = (Property("diameter", required=False), Property("force_error", required=False))
"""Properties of any cable: its diameter for interference checks, and the value that older versions
of CASPR report if no force is found."""

CASPR_CABLES: dict[str, CasprCable] = {
    "cable_ideal": CasprCable("ideal", _OTHER),
    "cable_linear_spring": CasprCable("linear_spring", (Property("K"), *_OTHER)),
    "cable_passive_linear_spring": CasprCable(
        "passive_spring", (Property("K"), Property("l0"), *_OTHER)
    ),
    "cable_vsd_torsion_spring": CasprCable(
        "vsd_torsion",
        (
            Property("K_cable"),
            Property("num_torsion_springs"),
            Property("torsion_spring_stiffness"),
            Property("torsion_spring_length"),
            *_OTHER,
        ),
    ),
    "cable_vsd_flexure_linear": CasprCable(
        "vsd_flexure",
        (Property("K_cable"), Property("vsd_force_deformation_relation", 3), *_OTHER),
    ),
    "cable_vsd_polynomial": CasprCable(
        "vsd_polynomial",
        (
            Property("K_cable"),
            Property("num_stiffness_polynomial_coeff"),
            Property("stiffness_poly_coeff", None, required=False),
            *_OTHER,
        ),
    ),
}


def cable_tag(kind: CableKind) -> str:
    """Return the element for a kind of cable; `cable_ideal` if CASPR does not support the kind."""
    tags = [tag for tag, cable in CASPR_CABLES.items() if cable.kind == kind]
    return tags[0] if tags else "cable_ideal"


CASPR_PULLEYS: dict[str, CasprPulley] = {
    "base_rotating_pulley": CasprPulley(
        "rotating",
        "fixed_location",
        (Property("pulley_radius"), Property("cable_entry_vector", 3)),
    ),
    "screw_base_rotating_pulley": CasprPulley(
        "screw",
        "constant_winch_point",
        (
            Property("winch_vector", 3),
            Property("cable_pulley_entry_vector", 3),
            Property("pulley_radius"),
            Property("winch_radius"),
            Property("winch_groove_width"),
        ),
    ),
}

CASPR_AXES: dict[str, Axis] = {
    "x": "x",
    "y": "y",
    "z": "z",
    "a": "alpha",
    "b": "beta",
    "g": "gamma",
}
"""Task axes by CASPR's letters."""

CASPR_TASKS: dict[str, str] = {
    "position": "xyz",
    "orientation_euler_xyz": "abg",
    "pose_euler_xyz": "xyzabg",
}
"""Allowed letters for each type of item in an operational space."""

ORIENTATION = "_orientation"
"""Suffix for the second task frame of a pose. A pose becomes a point and an orientation frame."""

CASPR_SPLINES: dict[Spline, str] = {
    "linear": "linear_spline_trajectory",
    "cubic": "cubic_spline_trajectory",
    "quintic": "quintic_spline_trajectory",
    "parabolic_blend": "parabolic_blend_trajectory",
    "samples": "file_trajectory",
}
"""XML element of each kind of trajectory."""

CASPR_DERIVATIVES: dict[Spline, int] = {"linear": 0, "parabolic_blend": 0, "cubic": 1, "quintic": 2}
"""Number of derivatives that each point specifies, by spline."""
