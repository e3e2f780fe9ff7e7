"""Designs for tests. Every function opens a new document and returns the API Design.

`FEATURES` contains the designs without required arguments, by name: one for each property that
other exporters cannot handle.
"""

from __future__ import annotations

from . import features
from .arm import PLANAR_2R, two_link_arm
from .features import *  # noqa: F403
from .parts import chain, nested_place, random_motion
from .simple import every_joint_type, many_links, shoulder_with_gimbal, single_cube

FEATURES = {
    name: function
    for name, function in vars(features).items()
    if getattr(function, "__module__", "") == features.__name__ and not name.startswith("_")
}

__all__ = [
    "FEATURES",
    "PLANAR_2R",
    "chain",
    "every_joint_type",
    "many_links",
    "nested_place",
    "random_motion",
    "shoulder_with_gimbal",
    "single_cube",
    "two_link_arm",
    *FEATURES,
]
