"""Springs along a path, and ligaments: passive muscles."""

from __future__ import annotations

from .law import MuscleLawDefinition, Rule, non_negative, positive, unbounded

LAWS = (
    MuscleLawDefinition(
        "passive_spring",
        "CASPR's spring, which pulls when long and pushes when short",
        "CASPR, CableModelPassiveLinearSpring: f = K (l - l0)",
        (
            non_negative("K", "N/m", None, "stiffness"),
            unbounded("l0", "m", None, "length without force"),
        ),
        at_start="l",
        pushes=True,
    ),
    MuscleLawDefinition(
        "path_spring",
        "OpenSim's spring along a path, slack when short",
        "OpenSim, PathSpring: f = K (l - l0) (1 + D l'), never below 0",
        (
            non_negative("stiffness", "N/m", None, "K"),
            non_negative("rest_length", "m", None, "l0: length at which it begins to pull"),
            non_negative("dissipation", "s/m", 0.0, "D"),
        ),
        at_start="lv",
        stretches=True,
    ),
    MuscleLawDefinition(
        "tendon_spring",
        "spring and damper of a MuJoCo tendon, which can also push",
        "MuJoCo: f = k (l - l_high) or k (l - l_low), + d l'",
        (
            non_negative("stiffness", "N/m", 0.0, "k"),
            non_negative("rest_low", "m", None, "length below which it pushes"),
            non_negative("rest_high", "m", None, "length above which it pulls"),
            non_negative("damping", "N.s/m", 0.0, "d"),
        ),
        rules=(Rule("rest_low <= rest_high"),),
        at_start="lv",
        pushes=True,
    ),
    MuscleLawDefinition(
        "ligament_blankevoort1991",
        "a ligament with a toe region, then linear; damped when lengthening",
        "Blankevoort, Kuiper, Huiskes & Grootenboer 1991, J. Biomech. 24",
        (
            non_negative(
                "linear_stiffness", "N", None, "force per unit strain above the toe region"
            ),
            positive("transition_strain", "1", 0.06, "strain at the end of the toe region"),
            non_negative(
                "damping_coefficient",
                "N.s",
                0.003,
                "force per unit strain rate while lengthening",
            ),
            positive("slack_length", "m", None, "length at which it begins to pull"),
        ),
        at_start="lv",
        damped="damping_coefficient != 0",
    ),
)
