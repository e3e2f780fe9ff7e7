"""Hill-type muscle with Bezier curves, whose knots are parameters."""

from __future__ import annotations

import math

from .hill import EXCITATION, FIBRE_DAMPING, RIGID, RULES, STATES, hill_parameters
from .law import MuscleLawDefinition, Parameter, Rule, Term, fraction, non_negative, positive

_MIN_VALUE, _MAX_VALUE = 1e-7, 1e7
"""Range of strains, forces over F0 and slopes in which the curves are numerically accurate."""

# (*) With an elastic tendon and no fibre damping, the velocity is computed from the force. As in
# OpenSim, these parameters are then at least 0.1 or at least half of the slope near vmax, and the
# minimum activation is at least 0.01.
_PARAMETERS = (
    *hill_parameters(0.01, 0.04, 0.01),
    non_negative("fibre_damping", "1", 0.1, FIBRE_DAMPING),
    Parameter(
        "maximum_pennation", "rad", math.acos(0.1), 0.0, 1.57, "pennation of the shortest fibre"
    ),
    non_negative("active_shortest", "1", 0.4441, "fibre length at which active force begins"),
    non_negative("active_transition", "1", 0.73, "fibre length at which the shallow slope begins"),
    non_negative("active_longest", "1", 1.8123, "fibre length at which active force ends"),
    non_negative("active_shallow_slope", "1", 0.8616, "slope below the optimal fibre length"),
    fraction("active_minimum", 0.0, "active force outside of these lengths (*)"),
    fraction(
        "concentric_slope_at_vmax",
        0.0,
        "slope of the force-velocity curve at the maximum shortening velocity (*)",
    ),
    fraction("concentric_slope_near_vmax", 0.25, "slope at 0.9 of that velocity"),
    Parameter("isometric_slope", "1", 5.0, 1.0, math.inf, "slope at zero velocity", open_low=True),
    fraction("eccentric_slope_at_vmax", 0.0, "slope at the maximum lengthening velocity (*)"),
    fraction("eccentric_slope_near_vmax", 0.15, "slope at 0.9 of that velocity"),
    Parameter(
        "eccentric_force",
        "1",
        1.4,
        1.0,
        math.inf,
        "force at the maximum lengthening velocity, over F0",
        open_low=True,
    ),
    fraction("concentric_curviness", 0.6, "curviness of the shortening part"),
    fraction("eccentric_curviness", 0.9, "curviness of the lengthening part"),
    Parameter(
        "passive_zero_strain",
        "1",
        0.0,
        -1.0,
        math.inf,
        "fibre strain at which passive force begins",
    ),
    Parameter(
        "passive_fibre_strain",
        "1",
        0.7,
        _MIN_VALUE,
        math.inf,
        "fibre strain at which passive force is F0",
    ),
    positive("passive_stiffness_low", "1", 0.2, "slope at which passive force begins"),
    Parameter(
        "passive_stiffness",
        "1",
        0.0,
        0.0,
        _MAX_VALUE,
        "slope at F0; 0: 2 / (passive_fibre_strain - passive_zero_strain)",
    ),
    fraction("passive_curviness", 0.75, "curviness of the passive curve"),
    Parameter("tendon_strain", "1", 0.049, _MIN_VALUE, math.inf, "tendon strain at F0"),
    Parameter(
        "tendon_stiffness", "1", 0.0, 0.0, _MAX_VALUE, "slope at F0; 0: 1.375 / tendon_strain"
    ),
    Parameter(
        "tendon_toe_force",
        "1",
        2 / 3,
        _MIN_VALUE,
        1.0,
        "force over F0 at which the tendon curve becomes linear",
    ),
    fraction("tendon_curviness", 0.5, "curviness of the toe region"),
)

_ACTIVE = (
    Rule("active_shortest < active_transition < 0.95 and 1.1 < active_longest"),
    Term("mean_rise", "1 / (0.95 - active_shortest)"),
    Rule(
        "active_shallow_slope < mean_rise",
        "mean_rise is the mean slope between active_shortest and the plateau",
    ),
    Term("at_transition", "1 - active_shallow_slope * (0.95 - active_transition)"),
    Rule(
        "active_minimum < at_transition / 2",
        "at_transition is the active force at active_transition",
    ),
)

_VELOCITY = (
    Rule("concentric_slope_at_vmax <= concentric_slope_near_vmax"),
    Rule("eccentric_slope_at_vmax <= eccentric_slope_near_vmax"),
    Rule("eccentric_slope_near_vmax < eccentric_force - 1"),
    Rule("concentric_slope_near_vmax < 1"),
    Rule(
        "isometric_slope > max(eccentric_force - 1, 1) / 0.9",
        "the slope at zero velocity must reach the ends of the curve",
    ),
)

_PASSIVE = (
    Rule("passive_fibre_strain > passive_zero_strain"),
    Term("strain", "passive_fibre_strain - passive_zero_strain"),
    Term("stiffness", "passive_stiffness if passive_stiffness > 0 else 2 / strain"),
    Term("toe", "min(0.1 / stiffness, 0.1 * strain)"),
    Term("mean_stiffness", "(1 - passive_stiffness_low * toe / 2) / (strain - toe)"),
    Rule(
        "passive_stiffness_low < mean_stiffness",
        "mean_stiffness is the mean slope of the passive curve",
    ),
    Rule(
        "passive_stiffness == 0 or passive_stiffness > mean_stiffness",
        "mean_stiffness is the mean slope of the passive curve",
    ),
)

_TENDON = (Rule("tendon_stiffness == 0 or tendon_stiffness > 1 / tendon_strain"),)

LAWS = (
    MuscleLawDefinition(
        "hill_millard2012",
        "a Hill-type muscle with Bezier curves and damping",
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
