"""Winches: a motor with gear and drum that winds up an elastic cable."""

from __future__ import annotations

from .law import MAX_VALUE, Command, LawState, MuscleLawDefinition, bounded

_WINCH = (
    bounded("drum_radius", "m", None, 1e-6, "r, to the middle of the cable"),
    bounded(
        "drum_pitch",
        "m",
        0.0,
        0.0,
        "p: way along the drum a turn; a turn winds up a helix. The cable leaves at one place, as "
        "from a drum that travels",
    ),
    bounded("gear_ratio", "1", 1.0, 1e-3, "N: motor turns a drum turn"),
    bounded("motor_inertia", "kg.m2", None, 1e-9, "J_M, of rotor and gear, on the motor's side"),
    bounded("drum_inertia", "kg.m2", 0.0, 0.0, "J_D"),
    bounded("viscous_friction", "N.m.s/rad", 0.0, 0.0, "b, about the drum's axis"),
    bounded(
        "dry_friction",
        "N.m",
        0.0,
        0.0,
        "Tc, about the drum's axis: it holds the drum up to that, and brakes with it",
    ),
    bounded("axial_stiffness", "N", None, 1e-3, "EA, of the cable"),
    bounded("dissipation", "s", 0.0, 0.0, "D"),
    bounded("lead_length", "m", 0.0, 0.0, "l_lead: cable between the drum and the first via point"),
    bounded("rest_length", "m", 0.0, -MAX_VALUE, "l_0: cable on the path with the drum at 0"),
    bounded("max_torque", "N.m", None, 1e-9, "T_max, of the motor; largest command of a torque"),
)

_STATES = (
    LawState("drum_speed", "rad/s", at_start=""),
    LawState("drum_angle", "rad", at_start="ul"),
)

LAWS = (
    MuscleLawDefinition(
        "winch",
        "a motor with gear and drum that winds up an elastic cable",
        "(N^2 J_M + J_D) w' = N u - r (f + EA e^2 / 2) - b w - Tc sgn w; f = EA e (1 + D e'), "
        "never below 0, e = (l - l_u) / (l_u + l_lead); l_u = l_0 - r theta. A drum takes up "
        "strain energy as well, EA e^2 / 2 a length",
        _WINCH,
        Command("torque", "N.m", "-max_torque", "max_torque"),
        _STATES,
        stretches=True,
        has_drum=True,
    ),
    MuscleLawDefinition(
        "winch_position",
        "the same with a drive that holds the length of cable",
        "winch, with N u = Kp (l_u - u) / r - Kd w within +-N T_max. A controller of forces "
        "commands a position that moves along with the path, tick by tick; it aims a few ticks "
        "ahead: a muscle_horizon of one alone overshoots",
        (
            *_WINCH,
            bounded(
                "position_gain", "N.m/rad", None, 1e-9, "Kp of the drive, about the drum's axis"
            ),
            bounded("velocity_gain", "N.m.s/rad", None, 0.0, "Kd, likewise"),
            bounded("longest_rest_length", "m", 1000.0, 1e-9, "largest command"),
        ),
        Command("rest_length", "m", 0.0, "longest_rest_length"),
        _STATES,
        stretches=True,
        has_drum=True,
    ),
)
