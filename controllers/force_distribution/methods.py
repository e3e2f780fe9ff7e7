"""Force distribution as functions over one pose or a stack of poses: CASPR's menu.

    -L'f = tau,   f_min <= f <= f_max

Every function is called as `distribute` is, without the name of a method: `least_squares(L, tau,
f_min, f_max)`.
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
"""The distributions by name."""


def distribute(
    L: ArrayLike,
    tau: ArrayLike,
    f_min: ArrayLike,
    f_max: ArrayLike,
    method: str = "least_squares",
    **options: Any,
) -> DistributedForces:
    """Return forces for one pose or a stack of them, by the method of that name.

    Args:
        L: Muscle Jacobians, shape (..., m, n), in [m/rad] or [m/m].
        tau: Desired torques, shape (..., n), in [N·m] or [N].
        f_min: Lower bounds, a number, shape (m,) or (..., m), in [N].
        f_max: Upper bounds, likewise; may be infinite if the method allows it.
        method: One of `METHODS`.
        options: Further keyword arguments of the method.

    Raises:
        InputError: A size, a number or an option is wrong, or the method does not fit the robot.
        UnknownNameError: There is no such method.
    """
    if method not in METHODS:
        raise UnknownNameError("force distribution", method, METHODS)
    function = METHODS[method]
    taken = inspect.unwrap(function).__kwdefaults__ or {}
    for option in options:
        if option not in taken:
            raise UnknownNameError(f"option of {method!r}", option, taken)
    return function(L, tau, f_min, f_max, **options)
