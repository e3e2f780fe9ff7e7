"""Numbers of robot files replaced: what is still read as a robot opens in the core and moves.

CARDSFLOW_MUTATIONS says how many are tried in all, 200 else. A hundred thousand take an hour or
two, and look for memory errors where library and Python are prepared for that, as .ci/run does it:

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
    """One to three of its numbers replaced."""
    text = file.read_bytes()
    for _ in range(rng.randint(1, 3)):
        found = rng.choice(list(NUMBER.finditer(text)))
        text = text[: found.start()] + rng.choice(NASTY) + text[found.end() :]
    file.write_bytes(text)


def use(path: Path) -> None:
    """All that the core computes of a robot."""
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
def test_a_damaged_robot_is_refused_or_moves(example: str, tmp_path: Path) -> None:
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
    print(f"\n{example}: {MUTATIONS} robots, {MUTATIONS - moved} refused")
    assert 0 < moved < 0.95 * MUTATIONS
