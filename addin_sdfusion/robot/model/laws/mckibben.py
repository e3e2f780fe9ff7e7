"""Pneumatic muscles."""

from __future__ import annotations

import math

from .law import Command, LawState, MuscleLawDefinition, Parameter, non_negative, positive

LAWS = (
    MuscleLawDefinition(
        "mckibben",
        "a pneumatic muscle: a bladder in a braided sleeve",
        "Chou & Hannaford 1996: F = p (3 L^2 - b^2) / (4 pi n^2)",
        (
            Parameter(
                "thread_length",
                "m",
                None,
                0.0,
                1e3,
                "b: length of a thread of the sleeve",
                open_low=True,
            ),
            Parameter(
                "turns",
                "1",
                None,
                1e-3,
                math.inf,
                "n: turns of the thread around the bladder",
            ),
            non_negative("cord_length", "m", 0.0, "path length in addition to the bladder"),
            positive("max_pressure", "Pa", 6e5, "largest command, relative to the ambient air"),
            non_negative(
                "pressure_time_constant", "s", 0.05, "time constant of the pressure; 0: immediate"
            ),
        ),
        Command("pressure", "Pa", 0.0, "max_pressure"),
        (LawState("pressure", "Pa", at_start="u", low=0.0, high="max_pressure"),),
        at_start="ul",
        at_once="pressure_time_constant == 0",
    ),
)
