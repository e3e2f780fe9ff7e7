"""Cables: ideal, elastic, heavy."""

from __future__ import annotations

import math

from .law import Command, MuscleLawDefinition, bounded, non_negative, positive

_REST_LENGTH = Command("rest_length", "m", 0.0, "longest_rest_length")

LAWS = (
    MuscleLawDefinition(
        "ideal",
        "a cable that pulls as commanded",
        "f = max(u, 0)",
        command=Command("force", "N", 0.0, math.inf),
    ),
    MuscleLawDefinition(
        "elastic_cable",
        "a cable with stiffness and damping; slack when too long",
        "f = k (l - u) + d l' while l > u, never below 0",
        (
            positive("stiffness", "N/m", None, "k"),
            non_negative("damping", "N.s/m", 0.0, "d"),
            positive("longest_rest_length", "m", 1000.0, "largest command"),
        ),
        _REST_LENGTH,
        damped="damping != 0",
        stretches=True,
    ),
    MuscleLawDefinition(
        "heavy_cable",
        "an elastic cable that sags by its weight between two points",
        "Irvine 1981, Cable Structures: the elastic catenary, in equilibrium at every moment. f is "
        "the tension along the chord, H l / a, + d l'; in addition the cable's weight pulls both "
        "ends down",
        (
            bounded("axial_stiffness", "N", None, 1e-3, "EA"),
            bounded("mass_per_length", "kg/m", None, 0.0, "mass per length of unstretched cable"),
            bounded("damping", "N.s/m", 0.0, 0.0, "d"),
            bounded(
                "longest_rest_length",
                "m",
                1000.0,
                1e-9,
                "largest command; a command below half the chord acts as half the chord",
            ),
        ),
        _REST_LENGTH,
        damped="damping != 0",
        sags=True,
    ),
)
