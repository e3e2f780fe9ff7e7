"""Hill-type muscles: common parameters, states and rules, and laws with few further parameters."""

from __future__ import annotations

import math

from .law import (
    Command,
    LawState,
    MuscleLawDefinition,
    Parameter,
    Rule,
    fraction,
    non_negative,
    positive,
)

EXCITATION = Command("excitation", "1", 0.0, 1.0)

STATES = (
    LawState("activation", "1", at_start="u", low=0.0, high=1.0),
    LawState("fibre_length", "m", "elastic_tendon != 0", at_start="ul", low=0.0),
)

RIGID = "elastic_tendon == 0"
"""Condition for damping: with an elastic tendon the tension does not depend on the rate."""

RULES = (
    Rule("elastic_tendon == 0 or elastic_tendon == 1"),
    Rule(
        "elastic_tendon == 0 or tendon_slack_length > 0",
        "an elastic tendon needs a tendon_slack_length",
    ),
)

FIBRE_DAMPING = "damping force over F0 at the maximum contraction velocity"


def hill_parameters(rise: float, fall: float, min_activation: float) -> tuple[Parameter, ...]:
    """Return the first parameters of all Hill-type muscles.

    Args:
        rise: Default time constant of rising activation, in [s].
        fall: Default time constant of falling activation, in [s].
        min_activation: Default minimum activation.
    """
    return (
        positive("max_isometric_force", "N", None, "F0"),
        positive("optimal_fibre_length", "m", None, "fibre length at which F0 is reached"),
        non_negative("tendon_slack_length", "m", None, "tendon length at which its force begins"),
        Parameter("pennation_at_optimal", "rad", 0.0, 0.0, 1.47, "angle between fibres and tendon"),
        Parameter(
            "max_contraction_velocity",
            "1/s",
            10.0,
            1e-6,
            math.inf,
            "in optimal fibre lengths per second",
        ),
        positive("activation_time_constant", "s", rise, "time constant of rising activation"),
        positive("deactivation_time_constant", "s", fall, "time constant of falling activation"),
        fraction("minimum_activation", min_activation, "lower limit of the activation"),
        fraction("elastic_tendon", 0.0, "1: elastic tendon, 0: rigid tendon"),
    )


LAWS = (
    MuscleLawDefinition(
        "hill_degroote2016",
        "a Hill-type muscle with smooth closed-form curves",
        "De Groote, Kinney, Rao & Fregly 2016, Ann. Biomed. Eng. 44",
        (
            *hill_parameters(0.015, 0.06, 0.0),
            non_negative("fibre_damping", "1", 0.0, FIBRE_DAMPING),
            positive("active_width_scale", "1", 1.0, "width of the active force-length curve"),
            positive("passive_fibre_strain", "1", 0.6, "fibre strain at which passive force is F0"),
            positive("tendon_strain", "1", 0.049, "tendon strain at F0"),
            positive("activation_smoothing", "1", 0.1, "smoothing between rising and falling"),
        ),
        EXCITATION,
        STATES,
        RULES,
        damped=RIGID,
    ),
    MuscleLawDefinition(
        "hill_thelen2003",
        "a Hill-type muscle with Thelen's curves",
        "Thelen 2003, J. Biomech. Eng. 125",
        (
            *hill_parameters(0.015, 0.05, 0.01),
            positive("tendon_strain", "1", 0.04, "tendon strain at F0"),
            positive("passive_fibre_strain", "1", 0.6, "fibre strain at which passive force is F0"),
            positive("active_shape", "1", 0.45, "gamma, shape of the active force-length curve"),
            Parameter(
                "passive_shape", "1", 5.0, 0.0, 100.0, "shape of the passive curve", open_low=True
            ),
            positive("concentric_shape", "1", 0.25, "Af, shape of the force-velocity curve"),
            Parameter(
                "eccentric_force",
                "1",
                1.4,
                1.0,
                math.inf,
                "maximum force while lengthening, over F0",
                open_low=True,
            ),
            Parameter(
                "linear_from",
                "1",
                0.95,
                0.0,
                1.0,
                "fraction of the range of the force-velocity curve above which it is linear",
                open_low=True,
            ),
        ),
        EXCITATION,
        STATES,
        (
            *RULES,
            Rule("linear_from < 1"),
            Rule("linear_from > 1 / eccentric_force", "the linear part must begin above F0"),
        ),
        damped=RIGID,
    ),
    MuscleLawDefinition(
        "hill_schutte1993",
        "a Hill-type muscle with spline curves through points",
        "Schutte, Rodgers, Zajac & Glaser 1993, IEEE Trans. Rehabil. Eng. 1; curves of OpenSim's "
        "wrist model",
        (
            *hill_parameters(0.1 / 9.126854, 0.1 / 1.459854, 0.0),
            non_negative("fibre_damping", "1", 0.1, FIBRE_DAMPING),
        ),
        EXCITATION,
        STATES,
        RULES,
        damped=RIGID,
    ),
)
