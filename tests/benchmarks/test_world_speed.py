"""Speed of worlds, as ratios within one run: `pytest tests/benchmarks -s`."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.interleaved import interleaved, record
from support.robots.worlds import two_link_arm

from addin_sdfusion.robot import Pose, Robot
from addin_sdfusion.robot.transforms.combine import Member, combine
from sim_dart import Plant
from sim_dart.scene import Ground, Scene

MANY, LIMIT, BLOCK = 20, 20.0, 50


def arms(count: int) -> Robot:
    """Return two-link arms at a distance of 2 m, with one muscle each."""
    arm = two_link_arm()
    joints = tuple(
        replace(joint, coordinates=(replace(joint.coordinates[0], initial=angle),))
        for joint, angle in zip(arm.joints, (1.2, 0.2), strict=True)
    )
    arm = replace(arm, joints=joints)
    places = (Pose((0.0, 2.0 * k, 0.0)) for k in range(count))
    return combine("arms", [Member(f"arm{k}", arm, place) for k, place in enumerate(places)])


SCENES = {
    "without contacts": (None, 0),
    "lying on the ground": (Scene(Ground(0.2), links="capsules", capsule_radius=0.03), 3000),
}


@pytest.mark.parametrize("case", SCENES)
def test_twenty_robots_cost_at_most_twenty_times_one(case: str) -> None:
    scene, settling = SCENES[case]
    blocks = {}
    for count in (1, MANY):
        plant = Plant(arms(count), scene=scene)
        forces = np.full(count, 1.0)
        for _ in range(settling):
            plant.step(forces)
        if settling:
            assert len(plant.world.contacts()) >= count
        state = plant.get_state()

        def block(plant: Plant = plant, state: object = state, forces: object = forces) -> None:
            plant.set_state(state)  # type: ignore[arg-type]
            for _ in range(BLOCK):
                plant.step(forces)  # type: ignore[arg-type]

        blocks[str(count)] = block
    best = interleaved(blocks, calls=1, rounds=30)
    ratio = best[str(MANY)] / best["1"]
    one = best["1"] / BLOCK * 1e6
    record(f"{MANY} two-link robots {case}, against one", ratio=ratio, us_per_step_of_one=one)
    assert ratio <= LIMIT
