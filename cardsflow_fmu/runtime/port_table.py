"""Table of variables for the C library, in the format of csrc/model/port_table.h."""

from __future__ import annotations

import hashlib
import struct
import zlib
from collections.abc import Sequence

from addin_sdfusion.robot import InputError
from cardsflow_fmu.cosim.signals.ports import Port
from cardsflow_fmu.cosim.signals.variables import Variable

_MAGIC = b"CARDSFMU"
_VERSION = 2
_HEADER_SIZE = 20
_CAUSALITIES = {"input": 0, "output": 1, "parameter": 2, "local": 1}
_VARIABILITIES = {"continuous": 0, "discrete": 1, "fixed": 2, "tunable": 3}


def _string(text: str) -> bytes:
    encoded = text.encode()
    if len(encoded) > 0xFFFF or b"\0" in encoded:
        raise InputError(f"{text[:40]!r} is not a valid name in an FMU")
    return struct.pack("<H", len(encoded)) + encoded + b"\0"


def _kinds(port: Port) -> bytes:
    return bytes((port.boolean, _CAUSALITIES[port.causality], _VARIABILITIES[port.variability]))


def _variable(variable: Variable) -> bytes:
    ports = variable.ports
    starts = struct.pack(f"<I{len(ports)}d", len(ports), *(port.start for port in ports))
    return _kinds(ports[0]) + starts + _string(variable.name)


def ports_digest(ports: Sequence[Port]) -> str:
    """Return a hash of the properties of ports that a host uses."""
    parts = [_kinds(port) + struct.pack("<d", port.start) + _string(port.name) for port in ports]
    return hashlib.sha256(b"".join(parts)).hexdigest()


def encode_port_table(
    variables: Sequence[Variable], *, guid: str, model_name: str, package: str, step: float
) -> bytes:
    """Return the contents of `ports.bin`."""
    strings = b"".join(map(_string, (guid, model_name, package)))
    counts = sum(len(variable.ports) for variable in variables), len(variables)
    body = strings + struct.pack("<dII", step, *counts) + b"".join(map(_variable, variables))
    return _MAGIC + struct.pack("<III", _VERSION, _HEADER_SIZE + len(body), zlib.crc32(body)) + body
