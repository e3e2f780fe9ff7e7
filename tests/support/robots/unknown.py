"""Robots that are not as their CAD says, by a seed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.model.robot import Inertia
from sim_dart.calibration.inertia import inertia_of, pseudo_inertia, thickened

POINT, SHAPE, DENSITY = 3e-3, 0.05, 0.1
DAMPING, FRICTION = (0.2, 0.6), (0.05, 0.2)


def true_robot(robot: Robot, rng: np.random.Generator) -> Robot:
    """Another robot with the names of a robot's parts: paths, masses and friction differ."""
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
    """That of the same body, stretched, moved and of another density."""
    P = pseudo_inertia(thickened(inertia))
    size = np.sqrt(np.trace(P[:3, :3]) / P[3, 3])
    T = np.eye(4)
    T[:3] += SHAPE * rng.normal(size=(3, 4)) * [1.0, 1.0, 1.0, size]
    P = np.exp(DENSITY * rng.normal()) * T @ P @ T.T
    S = P[:3, :3]
    I = np.trace(S) * np.eye(3) - S  # noqa: E741
    places = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    return inertia_of(np.array([P[3, 3], *P[:3, 3], *(I[place] for place in places)]))
