"""Muscles of Hill's type: what they share, and those with few parameters beside."""

from __future__ import annotations

import math

from .law import Command, LawState, MuscleLawDefinition, Parameter, Rule, natural, part, positive

EXCITATION = Command("excitation", "1", 0.0, 1.0)

STATES = (
    LawState("activation", "1", at_start="u"),
    LawState("fibre_length", "m", "elastic_tendon != 0", at_start="ul"),
)

RIGID = "elastic_tendon == 0"
"""A tendon that gives keeps the rate from the tension."""

RULES = (
    Rule("elastic_tendon == 0 or elastic_tendon == 1"),
    Rule(
        "elastic_tendon == 0 or tendon_slack_length > 0",
        "an elastic tendon needs a tendon_slack_length",
    ),
)

FIBRE_DAMPING = "force over F0 at the largest contraction velocity"


def hill_parameters(rise: float, fall: float, least_activation: float) -> tuple[Parameter, ...]:
    """What all muscles of Hill's type have, before their own parameters.

    Args:
        rise: Default of the time constant of rising activation, in [s].
        fall: Default of that of falling activation, in [s].
        least_activation: Default of the minimum activation.
    """
    return (
        positive("max_isometric_force", "N", None, "F0"),
        positive("optimal_fibre_length", "m", None, "where F0 is reached"),
        natural("tendon_slack_length", "m", None, "where the tendon begins to pull"),
        Parameter("pennation_at_optimal", "rad", 0.0, 0.0, 1.47, "angle of fibres to tendon"),
        Parameter(
            "max_contraction_velocity",
            "1/s",
            10.0,
            1e-6,
            math.inf,
            "optimal fibre lengths a second",
        ),
        positive("activation_time_constant", "s", rise, "of rising activation"),
        positive("deactivation_time_constant", "s", fall, "of falling activation"),
        part("minimum_activation", least_activation, "activation never falls below"),
        part("elastic_tendon", 0.0, "1: the tendon gives, 0: it is rigid"),
    )


LAWS = (
    MuscleLawDefinition(
        "hill_degroote2016",
        "a muscle of Hill's type with smooth closed-form curves",
        "De Groote, Kinney, Rao & Fregly 2016, Ann. Biomed. Eng. 44",
        (
            *hill_parameters(0.015, 0.06, 0.0),
            natural("fibre_damping", "1", 0.0, FIBRE_DAMPING),
            positive("active_width_scale", "1", 1.0, "widens the active force-length curve"),
            positive("passive_fibre_strain", "1", 0.6, "fibre strain at which it resists with F0"),
            positive("tendon_strain", "1", 0.049, "tendon strain at F0"),
            positive("activation_smoothing", "1", 0.1, "of the change from rising to falling"),
        ),
        EXCITATION,
        STATES,
        RULES,
        damped=RIGID,
    ),
    MuscleLawDefinition(
        "hill_thelen2003",
        "a muscle of Hill's type with Thelen's curves",
        "Thelen 2003, J. Biomech. Eng. 125",
        (
            *hill_parameters(0.015, 0.05, 0.01),
            positive("tendon_strain", "1", 0.04, "tendon strain at F0"),
            positive("passive_fibre_strain", "1", 0.6, "fibre strain at which it resists with F0"),
            positive("active_shape", "1", 0.45, "gamma, of the active force-length curve"),
            Parameter("passive_shape", "1", 5.0, 0.0, 100.0, "of the passive curve", open_low=True),
            positive("concentric_shape", "1", 0.25, "Af, of the force-velocity curve"),
            Parameter(
                "eccentric_force",
                "1",
                1.4,
                1.0,
                math.inf,
                "largest force while lengthening, over F0",
                open_low=True,
            ),
            Parameter(
                "linear_from",
                "1",
                0.95,
                0.0,
                1.0,
                "part of the force-velocity curve's range beyond which it goes on as a line",
                open_low=True,
            ),
        ),
        EXCITATION,
        STATES,
        (
            *RULES,
            Rule("linear_from < 1"),
            Rule("linear_from > 1 / eccentric_force", "the line begins above F0"),
        ),
        damped=RIGID,
    ),
    MuscleLawDefinition(
        "hill_schutte1993",
        "a muscle of Hill's type with curves through points",
        "Schutte, Rodgers, Zajac & Glaser 1993, IEEE Trans. Rehabil. Eng. 1; curves of OpenSim's "
        "model of the wrist",
        (
            *hill_parameters(0.1 / 9.126854, 0.1 / 1.459854, 0.0),
            natural("fibre_damping", "1", 0.1, FIBRE_DAMPING),
        ),
        EXCITATION,
        STATES,
        RULES,
        damped=RIGID,
    ),
)
