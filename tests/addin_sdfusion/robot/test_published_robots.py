from __future__ import annotations

import time

import pytest

from addin_sdfusion.robot import CardsflowError, Robot
from addin_sdfusion.robot.readers import read

CASPR = ("BMArm", "Example_2R_planar_XZ", "Example_planar_XY", "Example_spatial")
CASPR += ("Example_spherical", "RoboyLeftArm", "RoboyUpperBody")
CARDSFLOW = ("VRpuppet", "exosuit", "msj_platform", "musc-le", "roboy_icecream")
CARDSFLOW += ("roboy_upper_body", "test_robot")
PUBLISHED = [f"caspr/{name}" for name in CASPR] + [f"cardsflow/{name}" for name in CARDSFLOW]


@pytest.mark.parametrize("name", PUBLISHED)
def test_every_published_robot_is_read_or_its_defects_are_told(shared, name):
    start = time.perf_counter()
    try:
        reading = read(shared / "robots" / name)
    except CardsflowError as error:
        pytest.fail(f"not even read: {error}")
    assert isinstance(reading.robot, Robot) or any(f.is_error for f in reading.findings)
    assert all(f.file is not None and "\n" not in str(f) for f in reading.findings)
    assert time.perf_counter() - start < 2.0
