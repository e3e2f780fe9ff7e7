"""Encoding of the settings of native models as named fields, in the layout of the library."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from cardsflow_fmu.cosim.signals.groups import Groups, group_slices
from sim_dart.core.library import pack_field

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
        groups: Variables of the model.
        counts: All counts of the layout, by name.
        fields: All fields of the layout, by name. Only the number of elements must match.
    """
    kind = NATIVE_MODELS.index(model)
    body = struct.pack("<III", kind, len(blob), native_library().native_model_layout_hash(kind))
    body += blob + bytes(-len(blob) % 8) + _settings(_layout(model), groups, counts, fields)
    size = len(_MAGIC) + 12 + len(body)
    return _MAGIC + struct.pack("<III", _VERSION, size, zlib.crc32(body)) + body


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
