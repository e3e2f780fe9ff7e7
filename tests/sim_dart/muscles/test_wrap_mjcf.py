"""Wraps of robots that are written to MJCF, compared with MuJoCo."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
from support.robots.wrapped import single_wraps

from addin_sdfusion.robot import WrapSurface
from addin_sdfusion.robot.formats.mjcf.write import write_mjcf
from addin_sdfusion.robot.model.rotations import apply, inverse
from sim_dart import MusclePaths

pytestmark = pytest.mark.native


@pytest.mark.slow
@pytest.mark.parametrize("sides", [(0,), (1, -1)], ids=["shorter", "sides"])
def test_written_mujoco_model_has_the_same_tendon_lengths(
    tmp_path: Path, sides: tuple[int, ...]
) -> None:
    """Compare at the initial coordinates, which determine side sites, with both ends outside."""
    rng = np.random.default_rng(21)
    compared = wrapped = 0
    for k in range(3):
        robot = single_wraps(rng, 150, sides=sides)
        (file, *_) = write_mjcf(robot, tmp_path / str(k))
        model = mujoco.MjModel.from_xml_path(str(file))
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        lengths = MusclePaths(robot).evaluate(np.zeros(3)).lengths
        ends = [[np.array(p.position) for p in m.via_points] for m in robot.muscles]
        straight = np.array([np.linalg.norm(b - a) for a, b in ends])
        for m, (muscle, surface) in enumerate(zip(robot.muscles, robot.wrap_surfaces, strict=True)):
            if min(_distance(end, surface) for end in ends[m]) <= surface.radius:
                continue
            expected = data.ten_length[model.tendon(muscle.name).id]
            is_straight = lengths[m] < straight[m] + 1e-12
            is_odd = sides != (0,) and (
                is_straight or lengths[m] > straight[m] + 3 * surface.radius
            )
            if is_odd:  # MuJoCo differs if the straight line is free or the straight parts cross
                continue
            assert lengths[m] == pytest.approx(expected, abs=1e-9)
            compared += 1
            wrapped += not is_straight
    assert compared > 50
    assert wrapped > 40


def _distance(point: np.ndarray, surface: WrapSurface) -> float:
    x, y, z = apply(inverse(surface.pose), tuple(map(float, point)))
    flat = (x, y, z) if surface.shape == "sphere" else (x, y)
    return float(np.linalg.norm(flat))
