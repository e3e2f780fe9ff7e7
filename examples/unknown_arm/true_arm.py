"""Random arm that differs from its CAD model, and the experiment of its device.

    python examples/unknown_arm/true_arm.py --seed 1 -o true_arm
    cardsflow device true_arm --listen udp://127.0.0.1:5005

Via points are off by 3 mm, masses and their distribution by some 10 %, lengths by 5 mm, and the
joints have friction. Encoders of joints and muscles have 0.1 mrad and 0.1 mm of noise.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from addin_sdfusion.robot import Robot, read_robot
from addin_sdfusion.robot.formats.convert import convert
from addin_sdfusion.robot.model.robot import Inertia
from sim_dart.calibration.inertia import inertia_of, pseudo_inertia, thicken

EXAMPLES = Path(__file__).resolve().parent.parent
CAD = EXAMPLES / "roboy_left_arm" / "robot"
FLOWER = EXAMPLES / "no_joint_encoders" / "experiment.toml"

POINT, OFFSET, SHAPE, DENSITY = 3e-3, 5e-3, 0.05, 0.1
DAMPING, FRICTION = (0.2, 0.6), (0.05, 0.2)


def true_robot(robot: Robot, rng: np.random.Generator) -> Robot:
    """Return a random arm with the names of a robot's parts."""
    links = [
        replace(link, inertia=_another(link.inertia, rng)) if link.inertia.mass > 0 else link
        for link in robot.links
    ]
    muscles = []
    for muscle in robot.muscles:
        points = []
        for point in muscle.via_points:
            x, y, z = np.array(point.position) + POINT * rng.normal(size=3)
            points.append(replace(point, position=(x, y, z)))
        muscles.append(replace(muscle, via_points=tuple(points)))
    joints = []
    for joint in robot.joints:
        losses = []
        for c in joint.coordinates:
            damping, friction = (rng.uniform(*most) for most in (DAMPING, FRICTION))
            more = {"damping": c.damping + damping, "friction": c.friction + friction}
            losses.append(replace(c, **more))
        joints.append(replace(joint, coordinates=tuple(losses)))
    return replace(robot, links=tuple(links), joints=tuple(joints)).with_muscles(muscles)


def _another(inertia: Inertia, rng: np.random.Generator) -> Inertia:
    """Return the inertia of the same body, stretched, moved and with another density."""
    P = pseudo_inertia(thicken(inertia))
    size = np.sqrt(np.trace(P[:3, :3]) / P[3, 3])
    T = np.eye(4)
    T[:3] += SHAPE * rng.normal(size=(3, 4)) * [1.0, 1.0, 1.0, size]
    P = np.exp(DENSITY * rng.normal()) * T @ P @ T.T
    S = P[:3, :3]
    I = np.trace(S) * np.eye(3) - S  # noqa: E741
    places = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    return inertia_of(np.array([P[3, 3], *P[:3, 3], *(I[place] for place in places)]))


def experiment(offsets: dict[str, float], seed: int) -> str:
    """Return the experiment of the flower with this arm and its sensors."""
    text = FLOWER.read_text(encoding="utf-8")
    for old, new in (
        ("../roboy_left_arm/robot/model.sdf", "model.sdf"),
        ("mass_scale = 1.1", "mass_scale = 1.0"),
    ):
        assert old in text
        text = text.replace(old, new)
    rows = "\n".join(f"{name} = {offset!r}" for name, offset in offsets.items())
    sensors = f"[hardware.emulator]\nnoise = 1e-4\nseed = {seed}\n"
    return f"{text}\n{sensors}\n[hardware.emulator.length_offset]\n{rows}\n"


def main() -> None:
    """Write the robot and the experiment of its device."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder; new, or empty")
    options = parser.parse_args()
    rng, robot = np.random.default_rng(options.seed), read_robot(CAD)
    convert(true_robot(robot, rng), "sdf", options.output)
    offsets = {m.name: float(OFFSET * rng.normal()) for m in robot.muscles}
    text = experiment(offsets, options.seed)
    (options.output / "experiment.toml").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
