"""Messages of joint states: the bytes of rosbags, and what damaged ones give."""

from __future__ import annotations

import numpy as np
import pytest

from cardsflow_fmu.middleware.joint_state import JointStateReader, JointStateWriter

pytestmark = pytest.mark.extra("ros2")

NAME = "sensor_msgs/msg/JointState"
FIELDS = ("position", "velocity", "effort")


@pytest.mark.parametrize("seed", range(6))
def test_bytes_are_those_of_rosbags_either_way(seed: int) -> None:
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    random = np.random.default_rng(seed)
    names = ["x" * n for n in random.integers(0, 9, size=seed)]
    there = dict(zip(FIELDS, random.integers(0, 2, size=3) > 0, strict=True))
    rows = {field: random.normal(size=seed if there[field] else 0) for field in FIELDS}
    header = store.types["std_msgs/msg/Header"]
    time = store.types["builtin_interfaces/msg/Time"]
    theirs = store.types[NAME](header(time(17, 5), "f" * seed), names, **rows)
    expected = bytes(store.serialize_cdr(theirs, NAME))
    writer = JointStateWriter(names, "f" * seed, **there)
    given = [rows[field] for field in FIELDS if there[field]]
    assert writer.write(17_000_000_005, *given) == expected
    for order in (True, False):
        reader = JointStateReader()
        for _ in range(2):  # the second time with the names known
            read = reader.read(bytes(store.serialize_cdr(theirs, NAME, little_endian=order)))
            assert read is not None
            assert (read.time_ns, read.frame, list(read.names)) == (
                17_000_000_005,
                "f" * seed,
                names,
            )
            for field in FIELDS:
                np.testing.assert_array_equal(getattr(read, field), rows[field])


def test_no_damage_ends_a_program() -> None:
    random = np.random.default_rng(0)
    names = ("shoulder", "elbow")
    writer = JointStateWriter(names, position=True, effort=True)
    whole = writer.write(1, np.ones(2), np.ones(2))
    reader, refused = JointStateReader(), 0
    for _ in range(3000):
        damaged = bytearray(whole[: random.integers(0, len(whole) + 1)])
        for place in random.integers(0, max(len(damaged), 1), size=random.integers(0, 4)):
            if damaged:
                damaged[place] = random.integers(0, 256)
        refused += reader.read(bytes(damaged)) is None
    assert refused > 1000
    read = reader.read(whole)
    assert read is not None
    assert read.names == names
