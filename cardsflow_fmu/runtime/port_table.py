"""Writes the table of variables that the C library reads; csrc/port_table.h tells its format."""

from __future__ import annotations

import hashlib
import struct
import zlib
from collections.abc import Sequence

from addin_sdfusion.robot import InputError
from cardsflow_fmu.ports import Port

_MAGIC = b"CARDSFMU"
_VERSION = 1
_HEADER_SIZE = 20
_CAUSALITIES = {"input": 0, "output": 1, "parameter": 2}
_VARIABILITIES = {"continuous": 0, "discrete": 1, "fixed": 2, "tunable": 3}


def _string(text: str) -> bytes:
    encoded = text.encode()
    if len(encoded) > 0xFFFF or b"\0" in encoded:
        raise InputError(f"{text[:40]!r} cannot be a name in an FMU")
    return struct.pack("<H", len(encoded)) + encoded + b"\0"


def _port(port: Port) -> bytes:
    kinds = (port.boolean, _CAUSALITIES[port.causality], _VARIABILITIES[port.variability])
    return struct.pack("<BBBd", *kinds, port.start) + _string(port.name)


def ports_digest(ports: Sequence[Port]) -> str:
    """A hash of all that the C library knows of the variables."""
    return hashlib.sha256(b"".join(map(_port, ports))).hexdigest()


def encode_port_table(ports: Sequence[Port], *, guid: str, model_name: str, package: str) -> bytes:
    """The contents of `ports.bin`.

    Args:
        ports: The variables; the value reference is the index.
        guid: The GUID in the model description.
        model_name: Name of the model.
        package: Version of the package that builds the FMU.
    """
    strings = b"".join(map(_string, (guid, model_name, package)))
    body = strings + struct.pack("<I", len(ports)) + b"".join(map(_port, ports))
    return _MAGIC + struct.pack("<III", _VERSION, _HEADER_SIZE + len(body), zlib.crc32(body)) + body
