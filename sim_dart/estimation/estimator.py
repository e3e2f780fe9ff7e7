"""Pose estimator of a robot (extended Kalman filter or moving horizon), implemented in C."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError, Robot
from addin_sdfusion.robot.checks.check import require_valid
from sim_dart.core.arrays import FloatArray, vector
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core, library

from .estimated_robot import cable_compliances, estimated_robot, passive_muscles
from .imu_frames import imu_frames
from .settings import EstimatorSettings, Imu, arrays

NOT_CONVERGED = "not converged"
"""Status of a horizon that tracks, but whose last iterations did not converge."""
STATUSES = (
    *("waiting", "tracking", "ambiguous", "no pose matches", "unobservable", "diverged"),
    NOT_CONVERGED,
)
"""Names of the status values of the estimator, in the order of their numbers."""

_RANGE = np.pi
"""Search range of coordinates without limits on both sides of their start values."""


@cache
def _bound() -> Any:
    core = library()
    pointer, size, count = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int32
    core.estimator_size.argtypes = [pointer, count, count]
    core.estimator_size.restype = size
    core.estimator_open.argtypes = [pointer, count, pointer, count, pointer]
    core.estimator_open.restype = pointer
    core.estimator_array.argtypes = [pointer, ctypes.c_char_p, ctypes.POINTER(size)]
    core.estimator_array.restype = ctypes.POINTER(ctypes.c_double)
    core.estimator_reset.argtypes = [pointer]
    core.estimator_reset.restype = None
    core.estimator_tick.argtypes = [pointer, ctypes.c_double, count]
    core.estimator_find.argtypes = [pointer]
    core.estimator_use_transition.argtypes = [pointer, pointer, pointer]
    core.estimator_use_transition.restype = None
    core.estimator_horizon_size.argtypes = [pointer, count, count, count]
    core.estimator_horizon_size.restype = size
    core.estimator_use_horizon.argtypes = [pointer, count, pointer]
    core.core_transition_size.argtypes = [pointer]
    core.core_transition_size.restype = size
    core.core_transition_open.argtypes = [pointer, pointer]
    core.core_transition_open.restype = pointer
    return core


class PoseEstimator:
    """Estimator of q, qd and unknown loads w, based on the dynamics of the robot.

    The model is M qdd + C + G + w = -L'f with the generalised load w. For the equations see
    `sim_dart/csrc/estimator/estimator.h`, and `horizon/frames.h` for a moving horizon.

    Args:
        settings: Sensor noise and limits.
        start: Start pose, or first start pose of a search, shape (n,), in [rad] or [m] (default:
            the initial pose of the robot).
        imus: IMUs on moving links.

    Raises:
        RobotError: The robot is not valid.
        InputError: A setting does not fit the robot.
        UnknownNameError: A link does not exist.

    Attributes:
        lengths: Measured muscle lengths at the motors, shape (m,), in [m]. Write this and the
            following measurements before a tick, with NaN for missing values.
        tensions: Measured tensions, shape (m,), in [N].
        torques: Torques of joint motors, shape (n,), in [N·m] or [N].
        encoders: Measured joint positions, shape (n,), in [rad] or [m].
        gyroscope, accelerometer: Measurements in the IMU frame, shape (IMUs, 3), in [rad/s] and
            [m/s²].
        q, qd, w: The estimate, shape (n,) each, as views.
        biases: Biases of gyroscopes and accelerometers, shape (IMUs, 2, 3).
        offset_changes: Changes of the length offsets since the reset, shape (m,), in [m]; empty if
            the offsets are constant.
        sd: Standard deviations of q, qd, w, the biases and the offsets, shape
            (3 n + 6 IMUs + offsets,).
        covariance: Covariance of these values.
    """

    def __init__(
        self,
        robot: Robot,
        settings: EstimatorSettings | None = None,
        start: ArrayLike | None = None,
        imus: Sequence[Imu] = (),
    ) -> None:
        require_valid(robot)
        self.robot, self.settings = robot, settings or EstimatorSettings()
        self._core = Core(compile_blob(estimated_robot(robot)))
        n, m, i = len(robot.coordinates), len(robot.muscles), len(imus)
        c = self._c = _bound()
        self._frames, rotations, positions = imu_frames(robot, imus)
        o = m if self.settings.estimates_offsets else 0
        estimator_size = c.estimator_size(self._core.handle, i, o)
        frames = self.settings.frames if self.settings.type == "horizon" else 0
        horizon_size = c.estimator_horizon_size(self._core.handle, i, o, frames)
        self._memory = np.empty(-(-estimator_size // 8) - (-horizon_size // 8))
        address = self._memory.ctypes.data
        self._handle = ctypes.c_void_p(
            c.estimator_open(self._core.handle, i, self._frames.ctypes.data, o, address)
        )
        if frames:
            c.estimator_use_horizon(self._handle, frames, address + -(-estimator_size // 8) * 8)
        if self.settings.exact_transition:
            self._use_exact_transition()
        if start is None:
            start = [coordinate.initial for coordinate in robot.coordinates]
        self._write_settings(vector("start", start, n), rotations, positions)
        self.lengths, self.tensions = self.array("lengths", m), self.array("tensions", m)
        self.torques, self.encoders = self.array("torques", n), self.array("encoders", n)
        self.gyroscope = self.array("gyroscope", i, 3)
        self.accelerometer = self.array("accelerometer", i, 3)
        size = 3 * n + 6 * i + o
        state = self.array("state", size)
        self.q, self.qd, self.w = state[: 3 * n].reshape(3, n)
        self.biases = state[3 * n : size - o].reshape(i, 2, 3)
        self.offset_changes = state[size - o :]
        self.sd, self.covariance = self.array("sd", size), self.array("covariance", size, size)
        self._innovation, self._used = self.array("innovation", 1), self.array("used", 1)
        self._status, self._valid = self.array("status", 1), self.array("valid", 1)
        self._remembered = [self.array("remembered", -1)]
        if frames:
            self._remembered.append(self.array("remembered_frames", -1))
        self.reset()

    def array(self, name: str, *shape: int) -> FloatArray:
        """Return an array of the C library (see estimator.h) as a view of the given shape."""
        length = ctypes.c_size_t()
        pointer = self._c.estimator_array(self._handle, name.encode(), ctypes.byref(length))
        assert pointer, name
        address = ctypes.cast(pointer, ctypes.c_void_p).value or 0
        first = (address - self._memory.ctypes.data) // 8
        return self._memory[first : first + length.value].reshape(shape)

    @property
    def size(self) -> int:
        """Size of the working memory without the memory of the robot, in bytes."""
        return self._memory.nbytes

    @property
    def valid(self) -> bool:
        """Whether the estimator is tracking and the estimate is within all limits."""
        return bool(self._valid[0])

    @property
    def status(self) -> str:
        """Status of the estimator, one of `STATUSES`."""
        return STATUSES[int(self._status[0])]

    @property
    def innovation(self) -> float:
        """Mean square of the last normalised innovations; the expected value is 1."""
        return float(self._innovation[0])

    @property
    def used(self) -> int:
        """Number of measurements that the last tick used."""
        return int(self._used[0])

    def reset(self) -> None:
        """Reset the estimator to its initial state."""
        self._c.estimator_reset(self._handle)

    def tick(self, h: float, steps: int = 1) -> bool:
        """Advance by steps of h [s] and update the estimate with the written measurements.

        Returns:
            Whether the estimate is valid.
        """
        self._c.estimator_tick(self._handle, h, steps)
        return self.valid

    def find(self) -> str:
        """Search the start pose from the written measurements, and return the status."""
        last = self.array("last_tensions", len(self.tensions))
        last[:] = np.maximum(np.nan_to_num(self.tensions), 0.0)
        return STATUSES[self._c.estimator_find(self._handle)]

    def get_state(self) -> FloatArray:
        """Return the complete state of the estimator, for `set_state`."""
        return np.concatenate(self._remembered)

    def set_state(self, state: FloatArray) -> None:
        """Restore a state from `get_state`."""
        first = 0
        for array in self._remembered:
            array[:] = state[first : first + array.size]
            first += array.size

    def path_lengths(self, q: ArrayLike) -> FloatArray:
        """Return the path lengths l(q) of the model, shape (m,), in [m]."""
        self._core.move(self._core.handle, vector("q", q, len(self.q)).tobytes())
        return self._core.array("lengths", len(self.lengths)).copy()

    def home(self, q: ArrayLike, lengths: ArrayLike, tensions: ArrayLike) -> FloatArray:
        """Set the length offsets from measurements at a known pose.

        An error of the pose causes an error of the offsets.

        Args:
            q: The pose, shape (n,), in [rad] or [m].
            lengths: Lengths at the motors, mean of several measurements, shape (m,), in [m].
            tensions: Measured tensions, shape (m,), in [N]. Slack muscles keep their offsets.

        Returns:
            The offsets, shape (m,), in [m].
        """
        m = len(self.lengths)
        measured, pulls = vector("lengths", lengths, m), vector("tensions", tensions, m)
        offset, compliance = self.array("offset", m), self.array("compliance", m)
        taut = pulls > self.settings.min_tension
        offset[taut] = (measured - self.path_lengths(q) + compliance * pulls)[taut]
        return offset.copy()

    def _use_exact_transition(self) -> None:
        size = self._c.core_transition_size(self._core.handle)
        self._transition = np.empty(-(-size // 8))
        handle = self._c.core_transition_open(self._core.handle, self._transition.ctypes.data)
        function = ctypes.cast(self._c.core_transition_fill, ctypes.c_void_p)
        self._c.estimator_use_transition(self._handle, function, handle)

    def _write_settings(self, start: FloatArray, rotations: FloatArray, at: FloatArray) -> None:
        settings, n = self.settings, len(self.robot.coordinates)
        low = np.array([c.lower for c in self.robot.coordinates])
        high = np.array([c.upper for c in self.robot.coordinates])
        compliance = settings.compliance
        values = dict(arrays(settings)) | {
            "compliance": cable_compliances(self.robot) if compliance is None else compliance,
            "start": start,
            "start_low": np.where(np.isfinite(low), low, start - _RANGE),
            "start_high": np.where(np.isfinite(high), high, start + _RANGE),
            "imu_rotation": rotations.ravel(),
            "imu_position": at.ravel(),
        }
        if settings.type == "horizon":
            values["huber"] = settings.huber
            if settings.joint_limits:
                values |= {"low": low, "high": high}
        for name, value in values.items():
            target = self.array(name, -1)
            try:
                target[:] = value
            except (TypeError, ValueError):
                problem = f"{name} must be one number or {target.size}, not {value!r}"
                raise InputError(problem) from None
        self.array("length_noise", -1)[passive_muscles(self.robot)] = 0.0
        rest = self.array("start_sd", -1)
        rest[: 3 * n].reshape(3, n)[:] = [
            np.broadcast_to(np.asarray(sd, dtype=float), n)
            for sd in (settings.start_sd, settings.start_speed_sd, settings.start_load_sd)
        ]
        rest[3 * n :] = settings.gyroscope_bias_sd, settings.accelerometer_bias_sd
