"""Curves of the law `hill_schutte1993`, from OpenSim's wrist model.

The C core contains their cubic pieces, `sim_dart/csrc/laws/hill/hill_schutte1993.c`.
"""

from __future__ import annotations

from .function import SimmSpline

SCHUTTES_CURVES = {
    "tendon_force_length_curve": SimmSpline(
        (-10.0, -0.002, -0.001, 0.0, 0.00131, 0.00281, 0.00431, 0.00581, 0.00731, 0.00881, 0.0103,
         0.0118, 0.0123, 9.2, 9.201, 9.202, 20.0),
        (0.0, 0.0, 0.0, 0.0, 0.0108, 0.0257, 0.0435, 0.0652, 0.0915, 0.123, 0.161,
         0.208, 0.227, 345.0, 345.0, 345.0, 345.0),
    ),
    "active_force_length_curve": SimmSpline(
        (-35.0, 0.0, 0.401, 0.402, 0.4035, 0.52725, 0.62875, 0.71875, 0.86125, 1.045, 1.2175,
         1.43875, 1.61875, 1.62, 1.621, 2.2, 35.0),
        (0.0, 0.0, 0.0, 0.0, 0.0, 0.226667, 0.636667, 0.856667, 0.95, 0.993333, 0.77,
         0.246667, 0.0, 0.0, 0.0, 0.0, 0.0),
    ),
    "passive_force_length_curve": SimmSpline(
        (-35.0, 0.998, 0.999, 1.15, 1.25, 1.35, 1.45, 1.55, 1.65, 1.75, 1.7501, 1.7502, 35.0),
        (0.0, 0.0, 0.0, 0.0, 0.035, 0.12, 0.26, 0.55, 1.17, 2.0, 2.0, 2.0, 2.0),
    ),
}  # fmt: skip
"""Forces over F0 by OpenSim's names, as functions of tendon strain or normalised fibre length."""
RANGES = {
    "tendon_force_length_curve": (0.0, 0.033),
    "active_force_length_curve": (0.4, 1.8),
    "passive_force_length_curve": (0.4, 1.6),
}
"""Ranges of the curves in which a muscle operates, up to F0."""
