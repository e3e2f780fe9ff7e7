"""Signature of a list of signals, which must be equal on both sides of a link."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

from addin_sdfusion.robot.json_text import json_text


def port_signature(
    commands: Sequence[tuple[str, str]],
    states: Sequence[tuple[str, str]],
    *,
    command_kind: str = "force",
    scale: float = 1.0,
) -> int:
    """Return the hash of a list of signals, 64 bits.

    Args:
        commands: Name and unit of each value of a set point, in order, such as ("f.biceps", "N").
        states: Name and unit of each value of a state, in order, such as ("q.elbow", "rad").
        command_kind: Quantity that the motors control: "force", "length" or "velocity".
        scale: Scale of the values in frames. A value in a frame is the SI value divided by it.
    """
    ports = [
        command_kind,
        float(scale).hex(),
        [list(port) for port in commands],
        [list(port) for port in states],
    ]
    text = json_text(ports, ensure_ascii=True, separators=(",", ":"))
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "big")
