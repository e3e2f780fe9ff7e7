"""Winches: a motor with gear and drum that winds an elastic cable."""

from __future__ import annotations

from .law import MAX_VALUE, Command, LawState, MuscleLawDefinition, bounded

_WINCH = (
    bounded("drum_radius", "m", None, 1e-6, "r, from the drum's axis to the cable's centre"),
    bounded(
        "drum_pitch",
        "m",
        0.0,
        0.0,
        "p: axial advance of the cable per drum turn. The cable is wound as a helix and leaves the "
        "drum at a fixed point, as with a travelling drum",
    ),
    bounded("gear_ratio", "1", 1.0, 1e-3, "N: motor turns per drum turn"),
    bounded(
        "motor_inertia", "kg.m2", None, 1e-9, "J_M, inertia of rotor and gear on the motor's side"
    ),
    bounded("drum_inertia", "kg.m2", 0.0, 0.0, "J_D"),
    bounded("viscous_friction", "N.m.s/rad", 0.0, 0.0, "b, about the drum's axis"),
    bounded(
        "dry_friction",
        "N.m",
        0.0,
        0.0,
        "Tc, Coulomb friction torque about the drum's axis, at rest and in motion",
    ),
    bounded("axial_stiffness", "N", None, 1e-3, "EA of the cable"),
    bounded("dissipation", "s", 0.0, 0.0, "D"),
    bounded("lead_length", "m", 0.0, 0.0, "l_lead: cable between the drum and the first via point"),
    bounded("rest_length", "m", 0.0, -MAX_VALUE, "l_0: unstretched path length at drum angle 0"),
    bounded("max_torque", "N.m", None, 1e-9, "T_max, maximum motor torque and torque command"),
)

_STATES = (
    LawState("drum_speed", "rad/s", at_start=""),
    LawState("drum_angle", "rad", at_start="ul"),
)

LAWS = (
    MuscleLawDefinition(
        "winch",
        "a motor with gear and drum that winds an elastic cable",
        "(N^2 J_M + J_D) w' = N u - r (f + EA e^2 / 2) - b w - Tc sgn w; f = EA e (1 + D e'), "
        "never below 0, e = (l - l_u) / (l_u + l_lead); l_u = l_0 - r theta. The drum also takes "
        "up strain energy, EA e^2 / 2 per length",
        _WINCH,
        Command("torque", "N.m", "-max_torque", "max_torque"),
        _STATES,
        stretches=True,
        has_drum=True,
    ),
    MuscleLawDefinition(
        "winch_position",
        "a winch with a drive that controls the cable length",
        "winch, with N u = Kp (l_u - u) / r - Kd w within +-N T_max. A force controller commands "
        "a position that follows the path in every tick. Its muscle_horizon must be several "
        "ticks; a horizon of one tick overshoots",
        (
            *_WINCH,
            bounded(
                "position_gain", "N.m/rad", None, 1e-9, "Kp of the drive, about the drum's axis"
            ),
            bounded(
                "velocity_gain", "N.m.s/rad", None, 0.0, "Kd of the drive, about the drum's axis"
            ),
            bounded("longest_rest_length", "m", 1000.0, 1e-9, "largest command"),
        ),
        Command("rest_length", "m", 0.0, "longest_rest_length"),
        _STATES,
        stretches=True,
        has_drum=True,
    ),
)
