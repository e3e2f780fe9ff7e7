"""The parameters of the tension laws: name, unit, default, bounds, meaning."""

from __future__ import annotations

import math
from typing import NamedTuple


class Parameter(NamedTuple):
    """A number of a tension law.

    Attributes:
        name: Its name in files.
        unit: Its unit, as FMI writes units.
        default: What holds where it is not given; None if it must be.
        low: Smallest value.
        high: Largest value.
        meaning: What it is.
        open_low: Whether it must be above `low`.
    """

    name: str
    unit: str
    default: float | None
    low: float
    high: float
    meaning: str
    open_low: bool = False


_LEAST, _MOST = 1e-7, 1e7
"""Strains, forces over F0 and slopes beyond which a curve's pieces have no digits left."""

_LARGEST = 1e9
"""Of winches and heavy cables, in SI units: what none has, and the core still computes with."""


def _positive(name: str, unit: str, default: float | None, meaning: str) -> Parameter:
    return Parameter(name, unit, default, 0.0, math.inf, meaning, open_low=True)


def _natural(name: str, unit: str, default: float | None, meaning: str) -> Parameter:
    """Zero or above."""
    return Parameter(name, unit, default, 0.0, math.inf, meaning)


def _bounded(name: str, unit: str, default: float | None, low: float, meaning: str) -> Parameter:
    """From `low` to what no winch and no cable has."""
    return Parameter(name, unit, default, low, _LARGEST, meaning)


def _part(name: str, default: float, meaning: str) -> Parameter:
    """From 0 to 1."""
    return Parameter(name, "1", default, 0.0, 1.0, meaning)


ELASTIC_CABLE = (
    _positive("stiffness", "N/m", None, "k"),
    _natural("damping", "N.s/m", 0.0, "d"),
    _positive("longest_rest_length", "m", 1000.0, "largest command"),
)

HEAVY_CABLE = (
    _bounded("axial_stiffness", "N", None, 1e-3, "EA"),
    _bounded("mass_per_length", "kg/m", None, 0.0, "of cable that is not stretched"),
    _bounded("damping", "N.s/m", 0.0, 0.0, "d"),
    _bounded("longest_rest_length", "m", 1000.0, 1e-9, "largest command; one below half the "
             "chord acts as that"),
)  # fmt: skip

SPRING = (
    _natural("K", "N/m", None, "stiffness"),
    Parameter("l0", "m", None, -math.inf, math.inf, "length without force"),
)

MOTOR = (
    _positive("resistance", "Ohm", 0.797, "R, of the winding"),
    _natural("bridge_resistance", "Ohm", 0.0, "added to R: of the H-bridge"),
    _positive("inductance", "H", 1.8e-4, "La"),
    _natural("back_emf_constant", "V.s/rad", 1.42e-2, "Ke"),
    _positive("torque_constant", "N.m/A", 1.42e-2, "Kt"),
    _positive("gear_ratio", "1", 53.0, "N: motor turns a spindle turn"),
    Parameter("gear_efficiency", "1", 0.59, 0.0, 1.0, "eta: rho while the motor drives, 1 / rho "
              "while it is driven", open_low=True),
    _natural("gear_inertia", "kg.m2", 0.4e-7, "J_G, on the motor's side"),
    _positive("motor_inertia", "kg.m2", 4.09e-7, "J_M"),
    Parameter("spindle_radius", "m", 0.0045, 1e-6, math.inf, "r"),
    _positive("stiffness", "N/m", 30680.0, "k, of the spring"),
    Parameter("rest_length", "m", 0.0, -math.inf, math.inf,
              "l0: path length at which the spring has no force with the spindle at 0"),
    _positive("max_voltage", "V", 24.0, "largest command"),
)  # fmt: skip

WINCH = (
    _bounded("drum_radius", "m", None, 1e-6, "r, to the middle of the cable"),
    _bounded("drum_pitch", "m", 0.0, 0.0, "p: way along the drum a turn; a turn winds up a helix. "
             "The cable leaves at one place, as from a drum that travels"),
    _bounded("gear_ratio", "1", 1.0, 1e-3, "N: motor turns a drum turn"),
    _bounded("motor_inertia", "kg.m2", None, 1e-9, "J_M, of rotor and gear, on the motor's side"),
    _bounded("drum_inertia", "kg.m2", 0.0, 0.0, "J_D"),
    _bounded("viscous_friction", "N.m.s/rad", 0.0, 0.0, "b, about the drum's axis"),
    _bounded("dry_friction", "N.m", 0.0, 0.0, "Tc, about the drum's axis: it holds the drum up to "
             "that, and brakes with it"),
    _bounded("axial_stiffness", "N", None, 1e-3, "EA, of the cable"),
    _bounded("dissipation", "s", 0.0, 0.0, "D"),
    _bounded("lead_length", "m", 0.0, 0.0, "l_lead: cable between the drum and the first via "
             "point"),
    _bounded("rest_length", "m", 0.0, -_LARGEST, "l_0: cable on the path with the drum at 0"),
    _bounded("max_torque", "N.m", None, 1e-9, "T_max, of the motor; largest command of a torque"),
)  # fmt: skip

WINCH_POSITION = (
    *WINCH,
    _bounded("position_gain", "N.m/rad", None, 1e-9, "Kp of the drive, about the drum's axis"),
    _bounded("velocity_gain", "N.m.s/rad", None, 0.0, "Kd, likewise"),
    _bounded("longest_rest_length", "m", 1000.0, 1e-9, "largest command"),
)  # fmt: skip

ROBOY_MYO_MUSCLE = (
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

ROBOY_TEST_BENCH = (
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

MCKIBBEN = (
    Parameter(
        "thread_length", "m", None, 0.0, 1e3, "b: length of a thread of the sleeve", open_low=True
    ),
    Parameter("turns", "1", None, 1e-3, math.inf, "n: how often the thread goes round the bladder"),
    _natural("cord_length", "m", 0.0, "path length beside the bladder's own"),
    _positive("max_pressure", "Pa", 6e5, "largest command, above that of the air"),
    _natural("pressure_time_constant", "s", 0.05, "of the pressure behind its set point; 0: none"),
)


def _hill(
    rise: float, fall: float, least: float, own: tuple[Parameter, ...]
) -> tuple[Parameter, ...]:
    """What all muscles of Hill's type have, and what one of them has of its own."""
    return (
        _positive("max_isometric_force", "N", None, "F0"),
        _positive("optimal_fibre_length", "m", None, "where F0 is reached"),
        _natural("tendon_slack_length", "m", None, "where the tendon begins to pull"),
        Parameter("pennation_at_optimal", "rad", 0.0, 0.0, 1.47, "angle of fibres to tendon"),
        Parameter(
            "max_contraction_velocity",
            "1/s",
            10.0,
            1e-6,
            math.inf,
            "optimal fibre lengths a second",
        ),
        _positive("activation_time_constant", "s", rise, "of rising activation"),
        _positive("deactivation_time_constant", "s", fall, "of falling activation"),
        _part("minimum_activation", least, "activation never falls below"),
        Parameter("elastic_tendon", "1", 0.0, 0.0, 1.0, "1: the tendon gives, 0: it is rigid"),
        *own,
    )


DE_GROOTE = _hill(0.015, 0.06, 0.0, (
    _natural("fibre_damping", "1", 0.0, "force over F0 at the largest contraction velocity"),
    _positive("active_width_scale", "1", 1.0, "widens the active force-length curve"),
    _positive("passive_fibre_strain", "1", 0.6, "fibre strain at which it resists with F0"),
    _positive("tendon_strain", "1", 0.049, "tendon strain at F0"),
    _positive("activation_smoothing", "1", 0.1, "of the change from rising to falling"),
))  # fmt: skip

# (*) With an elastic tendon and no fibre damping the velocity follows from the force: then these
# are at least 0.1 and half of the slope near vmax, and the minimum activation is at least 0.01, as
# in OpenSim.
MILLARD = _hill(0.01, 0.04, 0.01, (
    _natural("fibre_damping", "1", 0.1, "force over F0 at the largest contraction velocity"),
    Parameter("maximum_pennation", "rad", math.acos(0.1), 0.0, 1.57, "of the shortest fibre"),
    _natural("active_shortest", "1", 0.4441, "fibre length where active force begins"),
    _natural("active_transition", "1", 0.73, "fibre length where the shallow slope begins"),
    _natural("active_longest", "1", 1.8123, "fibre length where active force ends"),
    _natural("active_shallow_slope", "1", 0.8616, "slope below the optimum"),
    _part("active_minimum", 0.0, "active force outside of these lengths (*)"),
    _part("concentric_slope_at_vmax", 0.0, "of the force-velocity curve, while shortening (*)"),
    _part("concentric_slope_near_vmax", 0.25, "at 0.9 of the contraction velocity"),
    Parameter("isometric_slope", "1", 5.0, 1.0, math.inf, "at rest", open_low=True),
    _part("eccentric_slope_at_vmax", 0.0, "at the largest lengthening speed (*)"),
    _part("eccentric_slope_near_vmax", 0.15, "at 0.9 of the largest lengthening speed"),
    Parameter("eccentric_force", "1", 1.4, 1.0, math.inf, "at that speed, over F0", open_low=True),
    _part("concentric_curviness", 0.6, "of the shortening part"),
    _part("eccentric_curviness", 0.9, "of the lengthening part"),
    Parameter("passive_zero_strain", "1", 0.0, -1.0, math.inf, "fibre strain where it resists"),
    Parameter("passive_fibre_strain", "1", 0.7, _LEAST, math.inf,
              "fibre strain at which it resists with F0"),
    _positive("passive_stiffness_low", "1", 0.2, "slope where it begins to resist"),
    Parameter("passive_stiffness", "1", 0.0, 0.0, _MOST,
              "slope at F0; 0: 2 over the strain between"),
    _part("passive_curviness", 0.75, "of the passive curve"),
    Parameter("tendon_strain", "1", 0.049, _LEAST, math.inf, "tendon strain at F0"),
    Parameter("tendon_stiffness", "1", 0.0, 0.0, _MOST,
              "slope at F0; 0: 1.375 over the strain"),
    Parameter("tendon_toe_force", "1", 2 / 3, _LEAST, 1.0, "where the tendon becomes linear"),
    _part("tendon_curviness", 0.5, "of the toe"),
))  # fmt: skip

THELEN = _hill(0.015, 0.05, 0.01, (
    _positive("tendon_strain", "1", 0.04, "tendon strain at F0"),
    _positive("passive_fibre_strain", "1", 0.6, "fibre strain at which it resists with F0"),
    _positive("active_shape", "1", 0.45, "gamma, of the active force-length curve"),
    Parameter("passive_shape", "1", 5.0, 0.0, 100.0, "of the passive curve", open_low=True),
    _positive("concentric_shape", "1", 0.25, "Af, of the force-velocity curve"),
    Parameter("eccentric_force", "1", 1.4, 1.0, math.inf, "largest force while lengthening, over "
              "F0", open_low=True),
    Parameter("linear_from", "1", 0.95, 0.0, 1.0, "part of the force-velocity curve's range "
              "beyond which it goes on as a line", open_low=True),
))  # fmt: skip

SCHUTTE = _hill(0.1 / 9.126854, 0.1 / 1.459854, 0.0, (
    _natural("fibre_damping", "1", 0.1, "force over F0 at the largest contraction velocity"),
))  # fmt: skip

MUJOCO = (
    Parameter("force", "N", None, -math.inf, math.inf, "F: largest active force; negative: scale / "
              "acc0"),
    Parameter("length_low", "m", None, -math.inf, math.inf, "path length where L is range_low"),
    Parameter("length_high", "m", None, -math.inf, math.inf, "path length where L is range_high"),
    _positive("range_low", "1", 0.75, "L of the shortest path, over the optimum"),
    _positive("range_high", "1", 1.05, "L of the longest path"),
    Parameter("lmin", "1", 0.5, -math.inf, 1.0, "where active force begins"),
    Parameter("lmax", "1", 1.6, 1.0, math.inf, "where active force ends", open_low=True),
    _positive("vmax", "1/s", 1.5, "shortening speed without force, in optima a second"),
    _natural("fpmax", "1", 1.3, "passive force at lmax, over F"),
    Parameter("fvmax", "1", 1.2, 1.0, math.inf, "active force while lengthening, over F"),
    _natural("scale", "N.m/s2", 200.0, "F times acc0, where force is negative"),
    _natural("acc0", "1/s2", 0.0, "length of the accelerations by a unit force at q = 0; for scale "
             "alone"),
    _natural("passive_range_low", "1", 0.0, "range_low of the passive force; both 0: the same"),
    _natural("passive_range_high", "1", 0.0, "range_high of the passive force"),
    _natural("passive_lmax", "1", 0.0, "lmax of the passive force; 0: the same"),
    _positive("activation_time_constant", "s", 0.01, "of rising activation"),
    _positive("deactivation_time_constant", "s", 0.04, "of falling activation"),
    _natural("activation_width", "1", 0.0, "of the change from rising to falling; 0: it switches"),
    _part("control_low", 0.0, "smallest command"),
    _part("control_high", 1.0, "largest command"),
)  # fmt: skip

PATH_SPRING = (
    _natural("stiffness", "N/m", None, "K"),
    _natural("rest_length", "m", None, "l0: where it begins to pull"),
    _natural("dissipation", "s/m", 0.0, "D"),
)

TENDON_SPRING = (
    _natural("stiffness", "N/m", 0.0, "k"),
    _natural("rest_low", "m", None, "length below which it pushes"),
    _natural("rest_high", "m", None, "length above which it pulls"),
    _natural("damping", "N.s/m", 0.0, "d"),
)

LIGAMENT = (
    _natural("linear_stiffness", "N", None, "force a unit of strain, beyond the toe"),
    _positive("transition_strain", "1", 0.06, "where the toe ends"),
    _natural("damping_coefficient", "N.s", 0.003, "force a unit of strain rate, if lengthening"),
    _positive("slack_length", "m", None, "where it begins to pull"),
)
