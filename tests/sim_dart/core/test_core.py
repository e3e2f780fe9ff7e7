"""Checks of blobs in the C core: a damaged blob is rejected, or it is a valid robot."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest
from support.robots.random_robots import random_robot
from support.robots.robots import planar_2r
from support.robots.wrapped import sequences, wrapped_tree

from addin_sdfusion.robot import CardsflowError
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core, library, pack_blob

pytestmark = pytest.mark.native


def test_every_truncated_blob_is_rejected() -> None:
    blob = compile_blob(planar_2r())
    for size in range(len(blob)):
        with pytest.raises(CardsflowError, match="rejects the robot"):
            Core(blob[:size])


@pytest.mark.slow
def test_mutated_blobs_are_rejected_or_can_be_moved() -> None:
    rng = np.random.default_rng(3)
    robots = [random_robot(0), *(wrapped_tree(random_robot(seed), seed) for seed in range(1, 4))]
    robots.append(sequences(rng, 4, 3, pulley=True))
    blobs = [compile_blob(robot) for robot in robots]
    refused = 0
    for _ in range(4000):
        blob = bytearray(blobs[rng.integers(len(blobs))])
        for _ in range(rng.integers(1, 4)):
            at = rng.integers(len(blob)) if rng.random() < 0.5 else rng.integers(200)
            blob[at] = rng.integers(256)
        try:
            core = Core(bytes(blob))
        except CardsflowError:
            refused += 1
            continue
        zeros = np.zeros(64).tobytes()
        core.move(core.handle, zeros)
        core.update_mass_matrix(core.handle)
        core.update_coriolis(core.handle, zeros)
        core.update_gravity(core.handle)
        core.update_task_bias(core.handle, zeros)
        core.accelerate(core.handle, zeros, zeros, zeros)
        core.trace(core.handle)
    assert refused > 1000


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("parent", [-1, 1], "frame 1: parent 1"),
        ("parent", [-2, 0], "frame 0: parent -2"),
        ("motion", [0, 7], "frame 1: unknown motion 7"),
        ("coordinate", [0, 3], "frame 1: unknown coordinate 3"),
        ("axis", [[0, 2, 0], [0, 1, 0]], "frame 0: its axis"),
        ("offset_rotation", [np.eye(3), np.ones((3, 3))], "frame 1: its rotation"),
        ("offset_position", [[0, 0, np.nan], [0, 0, 0]], "frame 0: its position"),
        ("coordinate", [1, 1], "frames 0 and 1 share coordinate 1"),
        ("mass", [-1, 1], "frame 0: its mass"),
        ("mass", [1, np.nan], "frame 1: its mass"),
        ("mass_centre", [[0, 0, 0], [0, np.inf, 0]], "frame 1: its inertia"),
        ("inertia", [[np.nan] * 6, [1] * 6], "frame 0: its inertia"),
        ("damping", [0, -1, 0], "coordinate 1: its damping"),
        ("friction", [0, -1], "coordinate 1: its friction"),
        ("friction", [np.inf, 0], "coordinate 0: its friction"),
        ("stiffness", [0, -1, 0], "coordinate 1: its spring"),
        ("rest", [np.inf, 0, 0], "coordinate 0: its spring"),
        ("lower", [0, 2], "coordinate 1: its limits"),
        ("upper", [np.nan, 1], "coordinate 0: its limits"),
        ("armature", [0, 0, -1], "coordinate 2: its armature"),
        ("limit_variable", [3], "limit force 0: unknown variable 3"),
        ("limit_numbers", [-1, 1, 0, 3, 0.1, 0, 0], "limit force 0: its numbers"),
        ("variable_terms", [0, 1, 1], "variable 1: it cannot have 1 functions"),
        ("variable_terms", [0, 0, 3], "variable 2: it cannot have 3 functions"),
        ("variable_terms", [0, 0, 1], "the functions' numbers do not add up to 17"),
        ("term_source", [0, 2], "function 1: its variable 2"),
        ("term_source", [-1, 0], "function 0: its variable -1"),
        ("term_kind", [2, 1], "function 0: unknown kind 2"),
        ("term_size", [2, 4], "function 1: unknown kind 1, or it has 4 numbers"),
        ("term_size", [0, 3], "function 0: unknown kind 0, or it has 0 numbers"),
        ("term_size", [1, 3], "the functions' numbers do not add up to 17"),
        ("term_number", [0, 1, *[np.inf] * 15], "numbers are not finite"),
        ("term_number", [0, 1, *np.arange(15.0)[::-1]], "function 1: its pieces are out of order"),
        ("gravity", [0, 0, np.nan], "gravity is not finite"),
        ("muscle_points", [1], "muscle 0: fewer"),
        ("muscle_points", [3], "do not add up"),
        ("muscle_bends", [1], "muscle 0: its cable does not have 1 bends"),
        ("presliding", [0.0], "muscle 0: its presliding"),
        ("point_frame", [-1, 2], "via point 1: unknown frame 2"),
        ("point_position", [[0, 0, 0], [np.inf, 0, 0]], "via point 1: its position"),
        ("task_kind", [2], "task 0: unknown kind 2"),
        ("task_rotation", [np.ones((3, 3))], "task 0: its rotation"),
        ("task_frame", [5], "task 0: unknown frame 5"),
    ],
)
def test_invalid_field_is_named(field: str, value: object, message: str) -> None:
    names = [line.split()[:2] for line in library().core_layout().decode().splitlines()]
    counts = dict.fromkeys((name for kind, name in names if kind == "count"), 0)
    counts |= {"dofs": 2, "muscles": 1, "points": 2, "tasks": 1, "robots": 1}
    counts |= {"limit_forces": 1, "frames": 2, "variables": 3, "terms": 2, "term_numbers": 17}
    fields: dict[str, object] = {name: [] for kind, name in names if kind != "count"}
    fields |= {
        "parent": [-1, 0],
        "motion": [0, 1],
        "coordinate": [0, 2],
        "offset_rotation": [np.eye(3), np.eye(3)],
        "offset_position": np.zeros((2, 3)),
        "axis": [[0, 1, 0], [0, 1, 0]],
        "mass": [1, 2],
        "mass_centre": np.zeros((2, 3)),
        "inertia": np.ones((2, 6)),
        "damping": [0, 0.1, 0],
        "limit_variable": [2],
        "limit_numbers": [-1, 1, 0, 3, 0.1, 0.2, 0],
        "armature": [0, 0, 0.1],
        "variable_terms": [0, 0, 2],
        "term_source": [1, 0],
        "term_kind": [0, 1],
        "term_size": [2, 3],
        "term_number": [0, 1, *np.arange(15.0)],
        "friction": [0, 0.2],
        "stiffness": [0, 1, 0],
        "rest": [0, 0.5, 0],
        "lower": [-np.inf, -1],
        "upper": [np.inf, 1],
        "gravity": [0, 0, -9.81],
        "muscle_points": [2],
        "muscle_bends": [0],
        "presliding": [1e-3],
        "point_frame": [-1, 1],
        "point_position": [[0, 0, 0], [1, 0, 0]],
        "task_kind": [0],
        "task_rotation": [np.eye(3)],
        "task_frame": [1],
        "task_position": [[0, 0, 1]],
        "law_kind": [0],
    }
    Core(pack_blob(counts, fields))
    with pytest.raises(CardsflowError, match=message):
        Core(pack_blob(counts, fields | {field: value}))


@pytest.mark.parametrize("capacity", [1, 2, 30, 64])
def test_message_is_truncated_at_its_capacity(capacity: int) -> None:
    blob = np.frombuffer(compile_blob(planar_2r()), np.float64)
    message = ctypes.create_string_buffer(b"?" * 64, 64)
    whole = f"the blob has {blob.nbytes - 8} bytes, its header specifies {blob.nbytes}"
    assert library().core_size(blob.ctypes.data, blob.nbytes - 8, message, capacity) == 0
    assert message.value.decode() == whole[: capacity - 1]
    assert message.raw[capacity:] == (b"?" * 64)[capacity:]


def test_layout_text_contains_every_count_and_field() -> None:
    lines = library().core_layout().decode().split("\n")
    assert lines[0] == "count dofs"
    assert "real point_position 3 points" in lines
