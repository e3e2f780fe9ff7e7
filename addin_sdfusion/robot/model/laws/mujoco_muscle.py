"""MuJoCo's muscle."""

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
    unbounded,
)

LAWS = (
    MuscleLawDefinition(
        "mujoco_muscle",
        "MuJoCo's muscle, of Hill's type with a rigid tendon",
        "MuJoCo: f = F (FL(L) FV(V) a + FP(L))",
        (
            unbounded("force", "N", None, "F: maximum active force; negative: scale / acc0"),
            unbounded("length_low", "m", None, "path length at which L is range_low"),
            unbounded("length_high", "m", None, "path length at which L is range_high"),
            positive("range_low", "1", 0.75, "L of the shortest path, over the optimal length"),
            positive("range_high", "1", 1.05, "L of the longest path, over the optimal length"),
            Parameter("lmin", "1", 0.5, -math.inf, 1.0, "length at which active force begins"),
            Parameter(
                "lmax",
                "1",
                1.6,
                1.0,
                math.inf,
                "length at which active force ends",
                open_low=True,
            ),
            positive(
                "vmax", "1/s", 1.5, "shortening speed at zero force, in optimal lengths per second"
            ),
            non_negative("fpmax", "1", 1.3, "passive force at lmax, over F"),
            Parameter("fvmax", "1", 1.2, 1.0, math.inf, "active force while lengthening, over F"),
            non_negative("scale", "N.m/s2", 200.0, "F times acc0, used if force is negative"),
            non_negative(
                "acc0",
                "1/s2",
                0.0,
                "norm of the acceleration caused by a unit force at q = 0; only used with scale",
            ),
            non_negative(
                "passive_range_low",
                "1",
                0.0,
                "range_low of the passive force; both 0: range_low and range_high",
            ),
            non_negative("passive_range_high", "1", 0.0, "range_high of the passive force"),
            non_negative("passive_lmax", "1", 0.0, "lmax of the passive force; 0: lmax"),
            positive("activation_time_constant", "s", 0.01, "time constant of rising activation"),
            positive(
                "deactivation_time_constant", "s", 0.04, "time constant of falling activation"
            ),
            non_negative(
                "activation_width",
                "1",
                0.0,
                "width of the transition from rising to falling; 0: a switch",
            ),
            fraction("control_low", 0.0, "smallest command"),
            fraction("control_high", 1.0, "largest command"),
        ),
        Command("excitation", "1", "control_low", "control_high"),
        (LawState("activation", "1", at_start="u", low=0.0, high=1.0),),
        rules=(
            Rule("length_low < length_high"),
            Rule("force >= 0 or acc0 > 0"),
            Rule("range_low < range_high"),
            Rule(
                "passive_range_low < passive_range_high"
                " or (passive_range_low == 0 and passive_range_high == 0)"
            ),
            Rule("lmin < 1"),
            Rule("passive_lmax == 0 or passive_lmax > 1"),
            Rule("control_low <= control_high"),
        ),
    ),
)
