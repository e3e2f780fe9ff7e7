"""The form of [hardware] in experiment.toml; see experiment_forms.py."""

from __future__ import annotations

from cardsflow_fmu.config.schema import (
    by_name,
    choice,
    either,
    flag,
    number,
    numbers,
    positive,
    rows,
    table,
    text,
    whole,
)

from .hardware_settings import COMMAND_KINDS, LONGEST_RAMP_DOWN, MODES

_FROM_ZERO, _ABOVE_ZERO = number(least=0), positive()

_MOTORS = table(
    "What the motors take.",
    {
        "command": choice("forces, lengths or velocities", COMMAND_KINDS, "force"),
        "stiffness": by_name("of the springs, in N/m", of=_ABOVE_ZERO),
        "damping": by_name("of the springs, in N·s/m", 0.0, of=_FROM_ZERO),
        "spindle_radius": by_name("where motors take angles, in m", of=_ABOVE_ZERO),
        "encoder_scale": by_name("counts per rad with a spindle_radius, else per m"),
        "offset": either(
            by_name(""), {"const": "start"}, meaning="set point where the motors count 0, in m"
        ),
    },
)

_CHANCE = "chance of a frame on its way, from 0 to 1"

_EMULATOR = table(
    "What is imperfect about an emulated robot, and its line.",
    {
        "motor_lag": number("time constant of the motors, in s", 0.0, least=0),
        "seed": whole("where noise and faults come from", 0, least=0),
        "joint_counts": positive("counts a radian or metre of the joints' encoders"),
        "length_counts": positive("counts a metre of the cables' encoders"),
        "noise": number("standard deviation of positions, in rad or m", 0.0, least=0),
        "differences": flag("whether velocities are differences of positions", False),
        **{key: number(_CHANCE, 0.0, least=0) for key in ("loss", "duplicate", "reorder")},
        "corrupt": number(_CHANCE, 0.0, least=0),
        "delay": number("of every frame, in s", 0.0, least=0),
        "jitter": number("most further delay, in s", 0.0, least=0),
        "outages": rows(numbers(2, "begin and length, in s"), "when no frame comes through"),
    },
)

HARDWARE = table(
    "What can be driven instead of the plant.",
    {
        "link": text("where it is, such as udp://127.0.0.1:5005"),
        "use": flag("whether runs drive it", False),
        "mode": choice("lockstep: the device takes a step a command", MODES, "realtime"),
        "bind": text("address of this machine to send from"),
        "key_file": text("the key that frames are signed with, relative to this file"),
        "max_missed": whole("exchanges in a row without a new state", 10, least=0),
        "watchdog": positive("without a command for so long the device is safe, in s"),
        "timeout": positive("longest wait for an answer in lockstep, in s", 1.0),
        "scale": positive("values travel divided by it", 1.0),
        "has_lengths": flag("whether muscle lengths are measured", True),
        "has_tensions": flag("whether tensions are measured", True),
        "approach": positive("to where the reference begins, in s"),
        "ramp_in": number("from the forces that hold the robot, in s", 0.2, least=0),
        "ramp_down": {
            "type": "number",
            "minimum": 0,
            "maximum": LONGEST_RAMP_DOWN,
            "description": "to f_min at the end, in s",
            "default": 0.5,
        },
        "force_rate": by_name("largest change of a force, in N/s", of=_ABOVE_ZERO),
        "tension_max": by_name("tension that ends a run, in N", of=_ABOVE_ZERO),
        "position_margin": by_name("beyond the joints' limits, in rad or m", of=_FROM_ZERO),
        "start_tolerance": by_name("from the start of the experiment, in rad or m", of=_FROM_ZERO),
        "motors": _MOTORS,
        "emulator": _EMULATOR,
    },
)
