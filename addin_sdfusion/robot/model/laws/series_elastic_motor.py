"""A DC motor that pulls on a spring: Roboy's myo-muscle, with its published numbers."""

from __future__ import annotations

import math

from .law import (
    Command,
    LawState,
    MuscleLawDefinition,
    Parameter,
    Rule,
    Term,
    free,
    natural,
    positive,
)

_ROBOY_MYO_MUSCLE = (
    ("resistance", 0.797),
    ("bridge_resistance", 0.0),
    ("inductance", 1.8e-4),
    ("back_emf_constant", 1.42e-2),
    ("torque_constant", 1.42e-2),
    ("gear_ratio", 53.0),
    ("gear_efficiency", 0.59),
    ("gear_inertia", 0.4e-7),
    ("motor_inertia", 4.09e-7),
    ("spindle_radius", 0.0045),
    ("stiffness", 30680.0),
)
"""What CARDSFlow's Gazebo plug-in simulates with, and the spring that it declares.

In effect the plug-in computes with a spring of 324.7 N/m (0.03247 N a tick, 1e4 ticks a metre).
"""

_ROBOY_TEST_BENCH = (
    ("resistance", 0.516),
    ("bridge_resistance", 0.0),
    ("inductance", 5.73e-5),
    ("back_emf_constant", 11.5e-3),
    ("torque_constant", 11.5e-3),
    ("gear_ratio", 128.0),
    ("gear_efficiency", 0.59),
    ("gear_inertia", 0.4e-7),
    ("motor_inertia", 14.5e-7),
    ("spindle_radius", 0.0045),
    ("stiffness", 30680.0),
)
"""What the plug-in's own test of a muscle uses; its spindle and spring are those of the plug-in."""

LAWS = (
    MuscleLawDefinition(
        "series_elastic_motor",
        "a DC motor with gear and spindle behind a spring",
        "Roboy's myo-motor: La i' = V - R i - Ke N w; N J w' = Kt i - r f / (rho N); "
        "f = k (l - l0 + r theta)",
        (
            positive("resistance", "Ohm", 0.797, "R, of the winding"),
            natural("bridge_resistance", "Ohm", 0.0, "added to R: of the H-bridge"),
            positive("inductance", "H", 1.8e-4, "La"),
            natural("back_emf_constant", "V.s/rad", 1.42e-2, "Ke"),
            positive("torque_constant", "N.m/A", 1.42e-2, "Kt"),
            positive("gear_ratio", "1", 53.0, "N: motor turns a spindle turn"),
            Parameter(
                "gear_efficiency",
                "1",
                0.59,
                0.0,
                1.0,
                "eta: rho while the motor drives, 1 / rho while it is driven",
                open_low=True,
            ),
            natural("gear_inertia", "kg.m2", 0.4e-7, "J_G, on the motor's side"),
            positive("motor_inertia", "kg.m2", 4.09e-7, "J_M"),
            Parameter("spindle_radius", "m", 0.0045, 1e-6, math.inf, "r"),
            positive("stiffness", "N/m", 30680.0, "k, of the spring"),
            free(
                "rest_length",
                "m",
                0.0,
                "l0: path length at which the spring has no force with the spindle at 0",
            ),
            positive("max_voltage", "V", 24.0, "largest command"),
        ),
        Command("voltage", "V", "-max_voltage", "max_voltage"),
        (
            LawState("current", "A", at_start="u"),
            LawState("spindle_speed", "rad/s", at_start=""),
            LawState("spindle_angle", "rad", at_start="ul"),
        ),
        rules=(
            Term("J", "gear_inertia + motor_inertia"),
            Term(
                "quickness",
                "(resistance + bridge_resistance) / inductance"
                " + sqrt(back_emf_constant * torque_constant / (inductance * J))"
                " + sqrt(stiffness * spindle_radius * spindle_radius"
                " / (gear_efficiency * gear_ratio * gear_ratio * J))",
            ),
            Rule(
                "quickness <= 1e6",
                "the motor changes at that rate, in [1/s], and faster ones would need steps below "
                "a microsecond; see inductance, inertias and stiffness",
            ),
        ),
        at_start="u",
        presets={"roboy_myo_muscle": _ROBOY_MYO_MUSCLE, "roboy_test_bench": _ROBOY_TEST_BENCH},
    ),
)
