"""Robot files with replaced numbers: a robot that can be read opens in the core and moves.

The number of files is CARDSFLOW_MUTATIONS (default: 200). A hundred thousand take one or two
hours. .ci/run prepares library and Python to detect memory errors:

    CARDSFLOW_MUTATIONS=100000 CARDSFLOW_LIBRARY_DIR=... LD_PRELOAD=... ASAN_OPTIONS=...  \
        python -m pytest -n 0 -s tests/native/test_damaged_robot_files.py
"""

from __future__ import annotations

import os
import random
import re
import shutil
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import CardsflowError, read_robot
from sim_dart import CoreDynamics, compile_blob
from sim_dart.core.library import Core

pytestmark = pytest.mark.native

ROBOTS = {
    "planar_2r": "robot",
    "roboy_left_arm": "robot",
    "pneumatic_elbow": "robot",
    "hill_arm": "robot",
}
MUTATIONS = int(os.environ.get("CARDSFLOW_MUTATIONS", "200")) // len(ROBOTS)
NUMBER = re.compile(rb"-?\d+\.?\d*(?:e-?\d+)?")
NASTY = [b"0", b"-1", b"1e-320", b"1e300", b"-1e300", b"1e9", b"nan", b"inf", b"2", b"0.5", b"-3.7"]


def damage(rng: random.Random, file: Path) -> None:
    """Return a copy with one to three replaced numbers."""
    text = file.read_bytes()
    for _ in range(rng.randint(1, 3)):
        found = rng.choice(list(NUMBER.finditer(text)))
        text = text[: found.start()] + rng.choice(NASTY) + text[found.end() :]
    file.write_bytes(text)


def use(path: Path) -> None:
    """Compute all quantities of a robot with the core."""
    robot = read_robot(path)
    dynamics = CoreDynamics(robot)
    q, qd = np.full((2, dynamics.n), 0.3)
    dynamics.acceleration(q, qd, -dynamics.muscle_jacobian(q).T @ dynamics.f_min)
    dynamics.task_bias(q, qd)
    core = Core(compile_blob(robot))
    core.array("q", dynamics.n)[:] = q
    core.move(core.handle, q.tobytes())
    core.step(core.handle, dynamics.f_min.tobytes(), None, 1e-3, 5)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:overflow encountered:RuntimeWarning")
@pytest.mark.filterwarnings("ignore:invalid value encountered:RuntimeWarning")
@pytest.mark.parametrize("example", ROBOTS)
def test_damaged_robot_is_rejected_or_moves(example: str, tmp_path: Path) -> None:
    moved = 0
    for number in range(MUTATIONS):
        rng, folder = random.Random(number), tmp_path / "robot"
        shutil.copytree(EXAMPLES / example / "robot", folder)
        files = [f for f in sorted(folder.iterdir()) if f.suffix in (".sdf", ".xml")]
        damage(rng, rng.choice([file for file in files if "trajectories" not in file.name]))
        with suppress(CardsflowError):
            use(folder)
            moved += 1
        shutil.rmtree(folder)
    print(f"\n{example}: {MUTATIONS} robots, {MUTATIONS - moved} rejected")
    assert 0 < moved < 0.95 * MUTATIONS
