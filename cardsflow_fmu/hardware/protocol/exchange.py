"""The outcome of one exchange with a device: a set point sent, a state received."""

from __future__ import annotations

from typing import NamedTuple

from cardsflow_fmu.utils.arrays import FloatArray


class Exchange(NamedTuple):
    """The outcome of a set point; a tuple, as one is made in every step.

    Attributes:
        state: Newest state, shape (states,), in SI units; None if nothing new came.
        seq: Sequence number of the set point that the newest state answers; 0 before any came.
        age: Time since the newest state was received, in [s]; infinite before any came.
        round_trip: From the sending of that set point until its state came, in [s]; NaN if nothing
            new came.
        device_flags: Flags of the newest state, bits of `frame.Flag`.
    """

    state: FloatArray | None
    seq: int
    age: float
    round_trip: float
    device_flags: int
