"""CASPR's names for cables, pulleys, operational spaces and trajectories, both directions."""

from __future__ import annotations

from typing import Literal, NamedTuple

from .model.muscle import CableKind
from .model.robot import Axis
from .model.trajectory import Spline


class Property(NamedTuple):
    """A number, or a row of numbers, that an element gives.

    Attributes:
        tag: Its element.
        size: How many numbers; None for any.
        required: Whether CASPR rejects an element without it.
    """

    tag: str
    size: int | None = 1
    required: bool = True

    def name(self, index: int) -> str:
        """Return the name of one of its numbers among the parameters of a cable, counted from 1."""
        return self.tag if self.size == 1 else f"{self.tag}_{index}"


class CasprCable(NamedTuple):
    """A cable element.

    Attributes:
        kind: What we call it.
        properties: Beside the force limits. The numbers of a row are parameters of their own:
            `<tag>_1`, `<tag>_2`, ...
    """

    kind: CableKind
    properties: tuple[Property, ...]


class CasprPulley(NamedTuple):
    """An attachment element that is a pulley at the base.

    Attributes:
        kind: What we call it.
        location: The element of the place where the cable comes from.
        properties: The other ones.
    """

    kind: Literal["rotating", "screw"]
    location: str
    properties: tuple[Property, ...]


_OTHER = (Property("diameter", required=False), Property("force_error", required=False))
"""What any cable may have: for interference, and older CASPR's mark for a force not found."""

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
    """Return the element for a cable of a kind; that of ideal ones for what CASPR does not have."""
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
"""The task axes by CASPR's letters."""

CASPR_TASKS: dict[str, str] = {
    "position": "xyz",
    "orientation_euler_xyz": "abg",
    "pose_euler_xyz": "xyzabg",
}
"""The letters that each item of an operational space may use."""

ORIENTATION = "_orientation"
"""A pose is two task frames: its point, and under its name with this the orientation."""

CASPR_SPLINES: dict[Spline, str] = {
    "linear": "linear_spline_trajectory",
    "cubic": "cubic_spline_trajectory",
    "quintic": "quintic_spline_trajectory",
    "parabolic_blend": "parabolic_blend_trajectory",
    "samples": "file_trajectory",
}
"""The element of each kind of trajectory."""

CASPR_DERIVATIVES: dict[Spline, int] = {"linear": 0, "parabolic_blend": 0, "cubic": 1, "quintic": 2}
"""How many derivatives a point gives, by spline."""
