"""A core with only the parts that a robot uses computes the same; it rejects other robots.

Firmware compiles these parts (csrc/optional_parts.h); here they are variables of one library.
"""

from __future__ import annotations

import ctypes

import numpy as np
import pytest
from support.native.precision import Precision, open_robot
from support.robots.bent_cables import with_bent_cables
from support.robots.robots import EXAMPLES, planar_2r
from support.robots.wrapped import over_ellipsoids, sequences

from addin_sdfusion.robot import Robot, read_robot
from addin_sdfusion.robot.model.laws import MUSCLE_LAWS
from sim_dart.core.supported_features import used_parts
from sim_dart.muscles.paths import MusclePaths

pytestmark = pytest.mark.slow

PARTS = ("WRAPS", "ELLIPSOIDS", "SEQUENCES", "ROUTES", "CABLE_FRICTION", "TASKS", "NORMS")
LEFT_OUT = "mckibben"


@pytest.fixture(scope="module")
def core(tmp_path_factory: pytest.TempPathFactory) -> Precision:
    """Compile a core whose parts are elements of an array, without one muscle law."""
    flags = ["-O0", '-DCARDSFLOW_PARTS="tests/native/csrc/variable_parts.h"']
    flags += [f"-DUSES_LAW_{law}={int(law != LEFT_OUT)}" for law in MUSCLE_LAWS]
    folder = tmp_path_factory.mktemp("parts")
    return Precision(folder, single=False, sources=["variable_parts.c"], flags=flags)


def robots() -> dict[str, Robot]:
    """Return robots that together use all parts of the core."""
    found = {name: read_robot(EXAMPLES / name / "robot") for name in ("hill_arm", "bicycle")}
    rng = np.random.default_rng(1)
    return found | {
        "planar_2r": planar_2r(),
        "ellipsoids": over_ellipsoids(),
        "sequences": sequences(rng, 2, 2),
        "pulley": sequences(rng, 2, 0, pulley=True),
        "bends": with_bent_cables(planar_2r(), 0.2, [0.1, 0.2]),
    }


def test_used_parts_compute_the_same_and_each_is_needed(core: Precision) -> None:
    """Lengths and L are bit-identical; without one of its parts, a robot is rejected."""
    used = (ctypes.c_int * len(PARTS)).in_dll(core.library, "used_parts")
    tested = set()
    for name, robot in robots().items():
        parts = {part for part in used_parts(robot) if not part.startswith("USES_LAW_")}
        tested |= parts
        used[:] = [int(f"USES_{part}" in parts) for part in PARTS]
        q = np.linspace(0.1, 0.3, len(robot.coordinates))
        opened, state = open_robot(core, robot), MusclePaths(robot).evaluate(q)
        opened.call("move", q)
        assert np.array_equal(opened.array("lengths"), state.lengths), name
        assert np.array_equal(opened.array("jacobian"), state.jacobian.ravel()), name
        for part in parts:
            without = PARTS.index(part.removeprefix("USES_"))
            used[without] = 0
            with pytest.raises(AssertionError, match=f"the robot needs {part}; define it in"):
                open_robot(core, robot)
            used[without] = 1
    assert tested == {f"USES_{part}" for part in PARTS[:5]}


def test_missing_muscle_law_is_rejected(core: Precision) -> None:
    robot = read_robot(EXAMPLES / "pneumatic_elbow/robot")
    with pytest.raises(AssertionError, match=f"the robot needs USES_LAW_{LEFT_OUT}; define it in"):
        open_robot(core, robot)
