"""Springs along a path, and ligaments: passive muscles."""

from __future__ import annotations

from .law import MuscleLawDefinition, Rule, free, natural, positive

LAWS = (
    MuscleLawDefinition(
        "passive_spring",
        "CASPR's spring: it pulls, and pushes when too short",
        "CASPR, CableModelPassiveLinearSpring: f = K (l - l0)",
        (
            natural("K", "N/m", None, "stiffness"),
            free("l0", "m", None, "length without force"),
        ),
        at_start="l",
        pushes=True,
    ),
    MuscleLawDefinition(
        "path_spring",
        "OpenSim's spring along a path, slack when too short",
        "OpenSim, PathSpring: f = K (l - l0) (1 + D l'), never below 0",
        (
            natural("stiffness", "N/m", None, "K"),
            natural("rest_length", "m", None, "l0: where it begins to pull"),
            natural("dissipation", "s/m", 0.0, "D"),
        ),
        at_start="lv",
        stretches=True,
    ),
    MuscleLawDefinition(
        "tendon_spring",
        "a spring and damper of MuJoCo's tendons; it pushes, too",
        "MuJoCo: f = k (l - l_high) or k (l - l_low), + d l'",
        (
            natural("stiffness", "N/m", 0.0, "k"),
            natural("rest_low", "m", None, "length below which it pushes"),
            natural("rest_high", "m", None, "length above which it pulls"),
            natural("damping", "N.s/m", 0.0, "d"),
        ),
        rules=(Rule("rest_low <= rest_high"),),
        at_start="lv",
        pushes=True,
    ),
    MuscleLawDefinition(
        "ligament_blankevoort1991",
        "a ligament: a toe, then a line; damped when pulled",
        "Blankevoort, Kuiper, Huiskes & Grootenboer 1991, J. Biomech. 24",
        (
            natural("linear_stiffness", "N", None, "force a unit of strain, beyond the toe"),
            positive("transition_strain", "1", 0.06, "where the toe ends"),
            natural(
                "damping_coefficient", "N.s", 0.003, "force a unit of strain rate, if lengthening"
            ),
            positive("slack_length", "m", None, "where it begins to pull"),
        ),
        at_start="lv",
        damped="damping_coefficient != 0",
    ),
)
