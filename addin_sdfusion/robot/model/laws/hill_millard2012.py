"""The muscle of Hill's type with Bezier curves, whose knots are parameters."""

from __future__ import annotations

import math

from .hill import EXCITATION, FIBRE_DAMPING, RIGID, RULES, STATES, hill_parameters
from .law import MuscleLawDefinition, Parameter, Rule, Term, natural, part, positive

_MIN_VALUE, _MAX_VALUE = 1e-7, 1e7
"""Strains, forces over F0 and slopes beyond which a curve's pieces have no digits left."""

# (*) With an elastic tendon and no fibre damping the velocity follows from the force: then these
# are at least 0.1 and half of the slope near vmax, and the minimum activation is at least 0.01, as
# in OpenSim.
_PARAMETERS = (
    *hill_parameters(0.01, 0.04, 0.01),
    natural("fibre_damping", "1", 0.1, FIBRE_DAMPING),
    Parameter("maximum_pennation", "rad", math.acos(0.1), 0.0, 1.57, "of the shortest fibre"),
    natural("active_shortest", "1", 0.4441, "fibre length where active force begins"),
    natural("active_transition", "1", 0.73, "fibre length where the shallow slope begins"),
    natural("active_longest", "1", 1.8123, "fibre length where active force ends"),
    natural("active_shallow_slope", "1", 0.8616, "slope below the optimum"),
    part("active_minimum", 0.0, "active force outside of these lengths (*)"),
    part("concentric_slope_at_vmax", 0.0, "of the force-velocity curve, while shortening (*)"),
    part("concentric_slope_near_vmax", 0.25, "at 0.9 of the contraction velocity"),
    Parameter("isometric_slope", "1", 5.0, 1.0, math.inf, "at rest", open_low=True),
    part("eccentric_slope_at_vmax", 0.0, "at the largest lengthening speed (*)"),
    part("eccentric_slope_near_vmax", 0.15, "at 0.9 of the largest lengthening speed"),
    Parameter("eccentric_force", "1", 1.4, 1.0, math.inf, "at that speed, over F0", open_low=True),
    part("concentric_curviness", 0.6, "of the shortening part"),
    part("eccentric_curviness", 0.9, "of the lengthening part"),
    Parameter("passive_zero_strain", "1", 0.0, -1.0, math.inf, "fibre strain where it resists"),
    Parameter(
        "passive_fibre_strain",
        "1",
        0.7,
        _MIN_VALUE,
        math.inf,
        "fibre strain at which it resists with F0",
    ),
    positive("passive_stiffness_low", "1", 0.2, "slope where it begins to resist"),
    Parameter(
        "passive_stiffness", "1", 0.0, 0.0, _MAX_VALUE, "slope at F0; 0: 2 over the strain between"
    ),
    part("passive_curviness", 0.75, "of the passive curve"),
    Parameter("tendon_strain", "1", 0.049, _MIN_VALUE, math.inf, "tendon strain at F0"),
    Parameter(
        "tendon_stiffness", "1", 0.0, 0.0, _MAX_VALUE, "slope at F0; 0: 1.375 over the strain"
    ),
    Parameter("tendon_toe_force", "1", 2 / 3, _MIN_VALUE, 1.0, "where the tendon becomes linear"),
    part("tendon_curviness", 0.5, "of the toe"),
)

_ACTIVE = (
    Rule("active_shortest < active_transition < 0.95 and 1.1 < active_longest"),
    Term("mean_rise", "1 / (0.95 - active_shortest)"),
    Rule("active_shallow_slope < mean_rise", "the mean slope up to the plateau"),
    Term("at_transition", "1 - active_shallow_slope * (0.95 - active_transition)"),
    Rule("active_minimum < at_transition / 2", "half of where the slope turns"),
)

_VELOCITY = (
    Rule("concentric_slope_at_vmax <= concentric_slope_near_vmax"),
    Rule("eccentric_slope_at_vmax <= eccentric_slope_near_vmax"),
    Rule("eccentric_slope_near_vmax < eccentric_force - 1"),
    Rule("concentric_slope_near_vmax < 1"),
    Rule(
        "isometric_slope > max(eccentric_force - 1, 1) / 0.9",
        "it reaches the ends of the curve",
    ),
)

_PASSIVE = (
    Rule("passive_fibre_strain > passive_zero_strain"),
    Term("strain", "passive_fibre_strain - passive_zero_strain"),
    Term("stiffness", "passive_stiffness if passive_stiffness > 0 else 2 / strain"),
    Term("toe", "min(0.1 / stiffness, 0.1 * strain)"),
    Term("mean_stiffness", "(1 - passive_stiffness_low * toe / 2) / (strain - toe)"),
    Rule("passive_stiffness_low < mean_stiffness", "the mean slope"),
    Rule(
        "passive_stiffness == 0 or passive_stiffness > mean_stiffness",
        "the mean slope",
    ),
)

_TENDON = (Rule("tendon_stiffness == 0 or tendon_stiffness > 1 / tendon_strain"),)

LAWS = (
    MuscleLawDefinition(
        "hill_millard2012",
        "a muscle of Hill's type with Bezier curves and damping",
        "Millard, Uchida, Seth & Delp 2013, J. Biomech. Eng. 135",
        _PARAMETERS,
        EXCITATION,
        STATES,
        (
            *RULES,
            Rule("pennation_at_optimal < maximum_pennation"),
            *_ACTIVE,
            *_VELOCITY,
            *_PASSIVE,
            *_TENDON,
        ),
        damped=RIGID,
    ),
)
