"""Encoding of the settings of native models as named fields, in the layout of the library."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from cardsflow_fmu.cosim.signals.groups import Groups, group_slices
from sim_dart.core.library import blob_fields, pack_field

from .binding import native_library

Counts = dict[str, int]
Fields = dict[str, ArrayLike]

NATIVE_MODELS = ("plant", "controller", "reference", "sensors", "estimator")
"""Names of native models, in the order of native/layout.h."""

_MAGIC = b"CARDSNAT"
_VERSION = 2
_KINDS = {"char": "u1", "uint32_t": "<u4", "int32_t": "<i4", "double": "<f8"}


def encode(
    model: str,
    blob: bytes,
    groups: Groups,
    counts: Mapping[str, int],
    fields: Mapping[str, ArrayLike],
) -> bytes:
    """Encode the file of a native model.

    Args:
        model: Name from `NATIVE_MODELS`.
        blob: Binary description of the robot; empty for a reference.
        counts: All counts of the layout, by name.
        fields: All fields of the layout, by name. Only the number of elements must match.
    """
    kind = NATIVE_MODELS.index(model)
    body = struct.pack("<III", kind, len(blob), native_library().native_model_layout_hash(kind))
    body += blob + bytes(-len(blob) % 8) + _settings(_layout(model), groups, counts, fields)
    size = len(_MAGIC) + 12 + len(body)
    return _MAGIC + struct.pack("<III", _VERSION, size, zlib.crc32(body)) + body


_CHANGED = {"sensors": ("noise", "stuck"), "plant": ("tension_scale", "break_time")}
"""Fields of models that may be changed in place."""


def field_places(model: str, file: bytes) -> dict[str, tuple[int, int]]:
    """Return offset in the file, and number of elements, of fields that may be changed in place.

    These are the fields of the robot, and `_CHANGED`. The CRC must be computed again.
    """
    begin = len(_MAGIC) + 24
    (size,) = struct.unpack_from("<I", file, begin - 8)
    blob = file[begin : begin + size]
    places = {
        name: (begin + at, count)
        for name, (at, count, _) in (blob_fields(blob) if size else {}).items()
    }
    lines = [line.split() for line in _layout(model)]
    at, sizes = begin + size + -size % 8, {}
    for kind, name, *rest in lines:
        if kind in ("group", "count"):
            sizes[name] = struct.unpack_from("<II", file, at)[1]
            at += 8
            continue
        count = int(rest[0]) * sizes[rest[1]]
        if name in _CHANGED.get(model, ()):
            places[name] = at, count
        at += (np.dtype(_KINDS[kind]).itemsize * count + 7) // 8 * 8
    return places


def _layout(model: str) -> list[str]:
    text: bytes = native_library().native_model_layout(NATIVE_MODELS.index(model))
    return text.decode().splitlines()


def _settings(
    layout: Sequence[str],
    groups: Groups,
    counts: Mapping[str, int],
    fields: Mapping[str, ArrayLike],
) -> bytes:
    places, sizes = group_slices(groups), {"models": 1, **counts}
    body = b""
    for line in layout:
        kind, name, *rest = line.split()
        if kind == "group":
            place = places[name]
            sizes[name] = place.stop - place.start
            body += struct.pack("<II", place.start, sizes[name])
        elif kind == "count":
            body += struct.pack("<II", 0, sizes[name])
        else:
            per_item, group = rest
            values = np.asarray(fields[name]).astype(_KINDS[kind])
            body += pack_field(name, values, int(per_item) * sizes[group])
    return body
