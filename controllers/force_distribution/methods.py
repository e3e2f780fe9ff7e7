"""Force distribution methods as functions of one pose or a stack of poses.

    -L'f = tau,   f_min <= f <= f_max

The methods correspond to those of CASPR. Every function has the arguments of `distribute` except
the name of the method: `least_squares(L, tau, f_min, f_max)`.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any

from numpy.typing import ArrayLike

from addin_sdfusion.robot import UnknownNameError

from .closed_form import closed_form, improved_closed_form, improved_puncture, puncture
from .linear import linear_programme, minimum_infinity_norm, optimally_safe
from .norms import p_norm
from .polygon import polygon_1_norm, polygon_2_norm, polygon_centroid
from .poses import DistributedForces
from .quadratic import least_squares

METHODS: Mapping[str, Callable[..., DistributedForces]] = {
    function.__name__: function
    for function in (
        least_squares,
        p_norm,
        linear_programme,
        minimum_infinity_norm,
        optimally_safe,
        closed_form,
        improved_closed_form,
        puncture,
        improved_puncture,
        polygon_1_norm,
        polygon_2_norm,
        polygon_centroid,
    )
}
"""Force distribution functions by name."""


def distribute(
    L: ArrayLike,
    tau: ArrayLike,
    f_min: ArrayLike,
    f_max: ArrayLike,
    method: str = "least_squares",
    **options: Any,
) -> DistributedForces:
    """Distribute torques over muscles for one pose or a stack of poses.

    Args:
        L: Muscle Jacobians, shape (..., m, n), in [m/rad] or [m/m].
        tau: Desired torques, shape (..., n), in [N·m] or [N].
        f_min: Lower limits, a number, shape (m,) or (..., m), in [N].
        f_max: Upper limits, a number, shape (m,) or (..., m), in [N]; may be infinite if the method
            allows it.
        method: Name of a method in `METHODS`.
        options: Further keyword arguments of the method.

    Raises:
        InputError: A size, a number or an option is invalid, or the method does not support the
            robot.
        UnknownNameError: The method or an option does not exist.
    """
    if method not in METHODS:
        raise UnknownNameError("force distribution", method, METHODS)
    function = METHODS[method]
    options_of_method = inspect.unwrap(function).__kwdefaults__ or {}
    for option in options:
        if option not in options_of_method:
            raise UnknownNameError(f"option of {method!r}", option, options_of_method)
    return function(L, tau, f_min, f_max, **options)
