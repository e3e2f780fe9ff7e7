"""DC motor that pulls on a spring: Roboy's myo-muscle with published parameters."""

from __future__ import annotations

import math

from .law import (
    Command,
    LawState,
    MuscleLawDefinition,
    Parameter,
    Rule,
    Term,
    non_negative,
    positive,
    unbounded,
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
"""Parameters of CARDSFlow's Gazebo plug-in, with the spring stiffness that it declares.

The plug-in actually computes with 324.7 N/m (0.03247 N per tick, 1e4 ticks per metre).
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
"""Parameters of the plug-in's muscle test, with the spindle and spring of the plug-in."""

LAWS = (
    MuscleLawDefinition(
        "series_elastic_motor",
        "a DC motor with gear and spindle in series with a spring",
        "Roboy's myo-motor: La i' = V - R i - Ke N w; N J w' = Kt i - r f / (rho N); "
        "f = k (l - l0 + r theta)",
        (
            positive("resistance", "Ohm", 0.797, "R, resistance of the winding"),
            non_negative(
                "bridge_resistance", "Ohm", 0.0, "resistance of the H-bridge, which is added to R"
            ),
            positive("inductance", "H", 1.8e-4, "La"),
            non_negative("back_emf_constant", "V.s/rad", 1.42e-2, "Ke"),
            positive("torque_constant", "N.m/A", 1.42e-2, "Kt"),
            positive("gear_ratio", "1", 53.0, "N: motor turns per spindle turn"),
            Parameter(
                "gear_efficiency",
                "1",
                0.59,
                0.0,
                1.0,
                "eta: rho is eta while the motor drives, 1 / eta while it is driven",
                open_low=True,
            ),
            non_negative("gear_inertia", "kg.m2", 0.4e-7, "J_G, on the motor's side"),
            positive("motor_inertia", "kg.m2", 4.09e-7, "J_M"),
            Parameter("spindle_radius", "m", 0.0045, 1e-6, math.inf, "r"),
            positive("stiffness", "N/m", 30680.0, "k, stiffness of the spring"),
            unbounded(
                "rest_length",
                "m",
                0.0,
                "l0: path length without spring force at spindle angle 0",
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
                "quickness is the fastest rate of the motor, in [1/s]; a faster motor requires "
                "steps below one microsecond; check inductance, inertias and stiffness",
            ),
        ),
        at_start="u",
        presets={"roboy_myo_muscle": _ROBOY_MYO_MUSCLE, "roboy_test_bench": _ROBOY_TEST_BENCH},
    ),
)
