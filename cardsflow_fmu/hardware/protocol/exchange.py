"""Result of an exchange with a device: a set point is sent and a state is received."""

from __future__ import annotations

from typing import NamedTuple

from cardsflow_fmu.utils.arrays import FloatArray


class Exchange(NamedTuple):
    """Result of an exchange. It is a tuple, since every step creates one.

    Attributes:
        state: New state, shape (states,), in SI units, or None if no new state has arrived.
        seq: Sequence number of the set point that the newest state answers, or 0 if no state has
            arrived yet.
        age: Time since the newest state arrived, in [s], or infinity if no state has arrived yet.
        round_trip: Time from sending the set point to the arrival of its state, in [s], or NaN if
            no new state has arrived.
        device_flags: Flags of the new state, bits of `frame.Flag`.
    """

    state: FloatArray | None
    seq: int
    age: float
    round_trip: float
    device_flags: int
