"""Smoothing splines of fifth order by FITPACK.

FITPACK cannot be interrupted, and may require minutes for a long recording. Such recordings are
fitted in a separate process with a limit of processor time:

python -P -m controllers.references.smoothing RESIDUAL < SAMPLES > SPLINE
"""

from __future__ import annotations

import contextlib
import io
import os
import signal
import subprocess
import sys
import warnings

import numpy as np

from addin_sdfusion.robot import InputError
from controllers.arrays import FloatArray

MAX_SECONDS = 20
"""Maximum processor time for a spline in a separate process, in [s]."""

_DEGREE = 5
_MAX_DIRECT = 5_000
"""Maximum number of samples that are fitted in this process."""
_OUT_OF_TIME = -getattr(signal, "SIGXCPU", sys.maxsize)


def smoothing_spline(
    times: FloatArray, q: FloatArray, residual: float
) -> tuple[FloatArray, FloatArray, int]:
    """Return knots, coefficients and degree of the spline with the fewest knots for a residual.

    Args:
        times: Times of the samples, shape (m,), in [s].
        q: Samples, shape (m,).
        residual: Sum of the squared differences between samples and spline.

    Raises:
        InputError: The spline requires too much time.
    """
    if len(times) <= _MAX_DIRECT or not sys.executable:
        return (*_fit(times, q, residual), _DEGREE)
    command = [sys.executable, "-P", "-m", __name__, repr(float(residual))]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    samples = _packed(times, q)
    done = subprocess.run(command, input=samples, capture_output=True, env=environment)
    if done.returncode == _OUT_OF_TIME:
        raise InputError(
            f"requires more than {MAX_SECONDS} s to smooth {len(times)} rows; use fewer rows, or "
            "set reference.noise to the standard deviation of the noise, or to 0"
        )
    if done.returncode != 0:
        lines = done.stderr.decode(errors="replace").strip().splitlines()
        raise InputError(f"cannot be smoothed: {lines[-1] if lines else done.returncode}")
    knots, coefficients = np.load(io.BytesIO(done.stdout))
    return knots, coefficients, _DEGREE


def _fit(times: FloatArray, q: FloatArray, residual: float) -> tuple[FloatArray, FloatArray]:
    from scipy.interpolate import splrep

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # the last iterate suffices
        knots, coefficients, _ = splrep(times, q, k=_DEGREE, s=residual)
    return knots, coefficients


def _packed(first: FloatArray, second: FloatArray) -> bytes:
    memory = io.BytesIO()
    np.save(memory, np.stack([first, second]))
    return memory.getvalue()


def main(residual: float) -> None:
    """Fit the samples from stdin and write the spline to stdout."""
    with contextlib.suppress(ImportError):  # does not exist on Windows
        import resource

        resource.setrlimit(resource.RLIMIT_CPU, (MAX_SECONDS, MAX_SECONDS + 1))
    times, q = np.load(io.BytesIO(sys.stdin.buffer.read()))
    sys.stdout.buffer.write(_packed(*_fit(times, q, residual)))


if __name__ == "__main__":
    main(float(sys.argv[1]))
