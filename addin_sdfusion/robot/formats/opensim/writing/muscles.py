"""Muscle laws in OpenSim: classes of muscles and ligaments, and their parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping
from xml.etree import ElementTree

from ....model.muscle import Muscle
from ....model.muscle_laws import law_parameters
from ....model.schutte_curves import SCHUTTES_CURVES
from ...writing.xml_text import element
from .functions import add_function

Names = Mapping[str, str]

CLASSES = {
    "hill_degroote2016": "DeGrooteFregly2016Muscle",
    "hill_millard2012": "Millard2012EquilibriumMuscle",
    "hill_thelen2003": "Thelen2003Muscle",
    "hill_schutte1993": "Schutte1993Muscle_Deprecated",
    "ligament_blankevoort1991": "Blankevoort1991Ligament",
    "path_spring": "PathSpring",
}
"""OpenSim class of each supported muscle law."""

_HILL: Names = {
    "max_isometric_force": "max_isometric_force",
    "optimal_fibre_length": "optimal_fiber_length",
    "tendon_slack_length": "tendon_slack_length",
    "pennation_at_optimal": "pennation_angle_at_optimal",
    "max_contraction_velocity": "max_contraction_velocity",
    "activation_time_constant": "activation_time_constant",
    "deactivation_time_constant": "deactivation_time_constant",
}

PROPERTIES: dict[str, Names] = {
    "hill_degroote2016": {
        **_HILL,
        "fibre_damping": "fiber_damping",
        "active_width_scale": "active_force_width_scale",
        "passive_fibre_strain": "passive_fiber_strain_at_one_norm_force",
        "tendon_strain": "tendon_strain_at_one_norm_force",
        "activation_smoothing": "activation_dynamics_smoothing",
    },
    "hill_millard2012": {
        **_HILL,
        "fibre_damping": "fiber_damping",
        "minimum_activation": "minimum_activation",
        "maximum_pennation": "maximum_pennation_angle",
    },
    "hill_thelen2003": {
        **_HILL,
        "tendon_strain": "FmaxTendonStrain",
        "passive_fibre_strain": "FmaxMuscleStrain",
        "active_shape": "KshapeActive",
        "passive_shape": "KshapePassive",
        "concentric_shape": "Af",
        "eccentric_force": "Flen",
        "linear_from": "fv_linear_extrap_threshold",
        "minimum_activation": "minimum_activation",
    },
    "hill_schutte1993": {
        **dict(list(_HILL.items())[:5]),
        "fibre_damping": "damping",
    },
    "ligament_blankevoort1991": {
        "linear_stiffness": "linear_stiffness",
        "transition_strain": "transition_strain",
        "damping_coefficient": "damping_coefficient",
        "slack_length": "slack_length",
    },
    "path_spring": {
        "stiffness": "stiffness",
        "rest_length": "resting_length",
        "dissipation": "dissipation",
    },
}

MILLARDS_CURVES: dict[str, Names] = {
    "ActiveForceLengthCurve": {
        "active_shortest": "min_norm_active_fiber_length",
        "active_transition": "transition_norm_fiber_length",
        "active_longest": "max_norm_active_fiber_length",
        "active_shallow_slope": "shallow_ascending_slope",
        "active_minimum": "minimum_value",
    },
    "ForceVelocityCurve": {
        "concentric_slope_at_vmax": "concentric_slope_at_vmax",
        "concentric_slope_near_vmax": "concentric_slope_near_vmax",
        "isometric_slope": "isometric_slope",
        "eccentric_slope_at_vmax": "eccentric_slope_at_vmax",
        "eccentric_slope_near_vmax": "eccentric_slope_near_vmax",
        "eccentric_force": "max_eccentric_velocity_force_multiplier",
        "concentric_curviness": "concentric_curviness",
        "eccentric_curviness": "eccentric_curviness",
    },
    "FiberForceLengthCurve": {
        "passive_zero_strain": "strain_at_zero_force",
        "passive_fibre_strain": "strain_at_one_norm_force",
        "passive_stiffness_low": "stiffness_at_low_force",
        "passive_stiffness": "stiffness_at_one_norm_force",
        "passive_curviness": "curviness",
    },
    "TendonForceLengthCurve": {
        "tendon_strain": "strain_at_one_norm_force",
        "tendon_stiffness": "stiffness_at_one_norm_force",
        "tendon_toe_force": "norm_force_at_toe_end",
        "tendon_curviness": "curviness",
    },
}
_NEEDED_FLAT = ("active_minimum", "concentric_slope_at_vmax", "eccentric_slope_at_vmax")
MIN_ACTIVATION = 0.01
"""Minimum of `minimum_activation` in OpenSim for muscles that would be singular."""


def force_element(forces: ElementTree.Element, muscle: Muscle) -> ElementTree.Element:
    """Add a muscle with its properties, but without its path.

    Args:
        muscle: The muscle. If OpenSim has no class for its law, it becomes a PathActuator, whose
            control is the tension in [N].
    """
    kind = muscle.model.kind
    if kind not in CLASSES:
        node = element(forces, "PathActuator", name=muscle.name)
        element(node, "min_control", muscle.f_min)
        element(node, "max_control", muscle.f_max)
        element(node, "optimal_force", 1.0)
        return node
    values = opensim_parameters(kind, law_parameters(muscle.model))
    node = element(forces, CLASSES[kind], name=muscle.name)
    if "minimum_activation" in values:
        element(node, "min_control", values["minimum_activation"])
        element(node, "max_control", 1.0)
        rigid = not values["elastic_tendon"]
        element(node, "ignore_tendon_compliance", "true" if rigid else "false")
    _properties(node, PROPERTIES[kind], values)
    if kind == "hill_millard2012":
        values |= millards_stiffnesses(values)
        for curve, names in MILLARDS_CURVES.items():
            _properties(element(node, curve, name=curve), names, values)
    if kind == "hill_schutte1993":
        _add_schuttes(node, values)
    return node


def _add_schuttes(node: ElementTree.Element, values: Mapping[str, float]) -> None:
    """Add the time constants and curves as OpenSim defines them."""
    scale = 1.0 / values["max_contraction_velocity"]
    fall = scale / values["deactivation_time_constant"]
    element(node, "time_scale", scale)
    element(node, "activation1", scale / values["activation_time_constant"] - fall)
    element(node, "activation2", fall)
    for name, curve in SCHUTTES_CURVES.items():
        add_function(node, [curve])
        node[-1].set("name", name)


def has_other_bounds(muscle: Muscle) -> dict[str, object]:
    """Return the class of a muscle whose force limits OpenSim cannot hold, for messages."""
    kind = muscle.model.kind
    has_bounds = muscle.f_min > 0.0 or muscle.f_max < math.inf
    return {"class": CLASSES[kind]} if kind in CLASSES and has_bounds else {}


def changed_parameters(muscle: Muscle) -> dict[str, object]:
    """Return the class of a muscle and the values that OpenSim changes, for messages."""
    kind = muscle.model.kind
    if kind not in CLASSES:
        return {}
    values = law_parameters(muscle.model)
    written = opensim_parameters(kind, values)
    changed = [f"{n} {written[n]:g}" for n in values if values[n] != written[n]]
    return {"class": CLASSES[kind], "values": ", ".join(changed)} if changed else {}


def ignored_damping(muscle: Muscle) -> dict[str, object]:
    """Return the class of a muscle and its fibre damping if OpenSim ignores it, for messages."""
    if muscle.model.kind != "hill_degroote2016":
        return {}
    parameters = law_parameters(muscle.model)
    if not (parameters["elastic_tendon"] and parameters["fibre_damping"]):
        return {}
    return {"class": CLASSES[muscle.model.kind], "damping": parameters["fibre_damping"]}


def opensim_parameters(kind: str, parameters: Mapping[str, float]) -> dict[str, float]:
    """Return the parameters with values that OpenSim accepts or actually uses."""
    values = dict(parameters)
    if kind == "hill_thelen2003":
        values["elastic_tendon"] = 1.0
        values["minimum_activation"] = max(values["minimum_activation"], MIN_ACTIVATION)
    if kind == "hill_schutte1993":
        values["elastic_tendon"] = 1.0
    if kind in ("hill_degroote2016", "hill_schutte1993"):
        values["minimum_activation"] = 0.0
    if kind == "hill_millard2012":
        if values["elastic_tendon"] and values["fibre_damping"] < 0.001:
            values["fibre_damping"] = 0.0
            values["minimum_activation"] = max(values["minimum_activation"], MIN_ACTIVATION)
        else:
            values |= dict.fromkeys(_NEEDED_FLAT, 0.0)
    return values


def millards_stiffnesses(values: Mapping[str, float]) -> dict[str, float]:
    """Return the slopes at F0; slopes of 0 are computed from the strains.

    OpenSim requires all parameters of a curve or none.
    """
    strain = values["passive_fibre_strain"] - values["passive_zero_strain"]
    return {
        "passive_stiffness": values["passive_stiffness"] or 2.0 / strain,
        "tendon_stiffness": values["tendon_stiffness"] or 1.375 / values["tendon_strain"],
    }


def _properties(node: ElementTree.Element, names: Names, values: Mapping[str, float]) -> None:
    for name, tag in names.items():
        element(node, tag, values[name])
