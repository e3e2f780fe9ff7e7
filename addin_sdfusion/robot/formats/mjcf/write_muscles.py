"""Muscle laws in MJCF: MuJoCo muscles and tendon springs."""

from __future__ import annotations

from ...model.muscle import Muscle
from ...model.muscle_laws import law_parameters
from ..writing.xml_text import numbers

MUSCLE = "mujoco_muscle"
SPRING = "tendon_spring"
LAWS = (MUSCLE, SPRING)
_SHARED = ("lmin", "lmax", "vmax", "fpmax", "fvmax")


def muscle_attributes(muscle: Muscle) -> dict[str, str]:
    """Return the attributes of a MuJoCo muscle; MuJoCo computes a negative `force` itself."""
    p = law_parameters(muscle.model)
    shared = [p[name] for name in _SHARED]
    gain = [p["range_low"], p["range_high"], p["force"], p["scale"], *shared]
    bias = list(gain)
    if p["passive_range_low"] or p["passive_range_high"]:
        bias[:2] = p["passive_range_low"], p["passive_range_high"]
    if p["passive_lmax"]:
        bias[5] = p["passive_lmax"]
    times = ("activation_time_constant", "deactivation_time_constant", "activation_width")
    kinds = {f"{part}type": "muscle" for part in ("dyn", "gain", "bias")}
    return kinds | {
        "dynprm": numbers(p[name] for name in times),
        "gainprm": numbers(gain),
        "biasprm": numbers(bias),
        "lengthrange": numbers((p["length_low"], p["length_high"])),
        "ctrllimited": "true",
        "ctrlrange": numbers((p["control_low"], p["control_high"])),
    }


def spring_attributes(muscle: Muscle) -> dict[str, str]:
    """Return the attributes of a tendon spring."""
    p = law_parameters(muscle.model)
    return {
        "stiffness": numbers([p["stiffness"]]),
        "damping": numbers([p["damping"]]),
        "springlength": numbers((p["rest_low"], p["rest_high"])),
    }
