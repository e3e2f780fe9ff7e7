"""Types of messages for CycloneDDS, whose samples carry the bytes of a message as they are."""

from __future__ import annotations

import functools
from typing import Any

from .node import dds_type
from .types import type_store


@functools.cache
def sample_type(name: str) -> Any:
    """The type of samples with messages of a type, such as `sensor_msgs/msg/JointState`.

    CycloneDDS needs the fields for what it tells others of the type. A sample itself has only
    `content`, CDR of version 1 with its header.
    """
    made = _struct(name)
    made.serialize = _serialize
    made.deserialize = made.deserialize_key = classmethod(_deserialize)
    return made


def _serialize(sample: Any, **_: object) -> bytes:
    return bytes(sample.content)


def _deserialize(cls: Any, /, content: bytes, **_: object) -> Any:
    sample = cls.__new__(cls)
    sample.content = content
    return sample


@functools.cache
def _struct(name: str) -> Any:
    from cyclonedds.idl import make_idl_struct
    from cyclonedds.idl.annotations import final

    own = name.rpartition("/")[2]
    fields = {field: _type(kind) for field, kind in type_store().get_msgdef(name).fields}
    return final(make_idl_struct(f"{own}_", dds_type(name), fields, dataclassify=False))


def _type(kind: Any) -> Any:
    """The type of a field as CycloneDDS has it."""
    from cyclonedds.idl import types
    from rosbags.interfaces import Nodetype

    node, details = kind
    if node == Nodetype.NAME:
        return _struct(details)
    if node == Nodetype.ARRAY:
        return types.array[_type(details[0]), details[1]]
    if node == Nodetype.SEQUENCE:
        return types.sequence[_type(details[0])]
    name, length = details
    if name in ("string", "wstring"):
        return types.bounded_str[length] if length else str
    python = {"bool": bool, "octet": types.byte, "byte": types.byte, "char": types.uint8}
    return python[name] if name in python else getattr(types, name)
