"""Robots with joints by functions of coordinates, and coupled and locked coordinates."""

from __future__ import annotations

import math

from addin_sdfusion.robot import (
    WORLD,
    CableSet,
    Coordinate,
    Inertia,
    Joint,
    LimitForce,
    Link,
    Motion,
    Muscle,
    PiecewiseLinear,
    Polynomial,
    Pose,
    Robot,
    SimmSpline,
    TaskFrame,
    TaskSet,
    Term,
    ViaPoint,
    revolute,
)

SLIDE = SimmSpline((-2.1, -1.2, -0.6, 0.0, 0.5, 2.0), (-0.0032, 0.0018, 0.004, 0.0, -0.01, 0.003))
ROLL = SimmSpline((-2.0, -0.9, 0.0, 0.4, 2.2), (0.1, -0.06, 0.0, 0.03, -0.1))


def leg() -> Robot:
    """Return a leg with a rolling and sliding knee, a coupled patella, a hip and a locked toe."""
    body = Inertia(1.3, (0.02, 0.01, -0.18), 0.03, 0.029, 0.004, 1e-3, -2e-3, 1e-3)
    small = Inertia(0.1, (0.01, 0.0, -0.02), 2e-4, 2.5e-4, 1e-4)
    knee = Joint(
        "knee",
        "thigh",
        "shank",
        (
            Motion("translation", (1.0, 0.0, 0.0), 0, SLIDE),
            Motion("translation", (0.0, 0.0, 1.0), 0, Polynomial((-0.4, 0.01, -0.02, 0.003))),
            Motion("rotation", (0.0, 1.0, 0.0), 0),
            Motion("rotation", (0.0, 0.6, 0.8), 0, ROLL),
            Motion("rotation", (1.0, 0.0, 0.0), 1, Polynomial((0.05, 1.0))),
        ),
        (
            Coordinate("flexion", -2.0, 0.3, -0.4, damping=0.3, stiffness=2.0, rest=-0.2),
            Coordinate("sway", armature=0.02, limit_force=LimitForce(-0.2, 0.3, 40.0, 50.0, 0.7)),
        ),
        Pose((0.0, 0.01, 0.0), (0.1, 0.0, 0.2)),
        Pose((0.0, 0.0, 0.02), (0.0, 0.3, 0.0)),
    )
    patella = Joint(
        "patella",
        "thigh",
        "kneecap",
        (
            Motion("translation", (1.0, 0.0, 0.0), 0, PiecewiseLinear((-2.0, 0.4), (0.05, 0.06))),
            Motion("rotation", (0.0, 1.0, 0.0), 0),
        ),
        (
            Coordinate(
                "glide",
                damping=0.05,
                stiffness=0.4,
                armature=0.003,
                coupling=(
                    Term("flexion", Polynomial((0.02, 0.7, -0.1))),
                    Term("hip", SimmSpline((-1.0, 0.0, 1.0, 2.0), (0.1, 0.0, 0.05, 0.3))),
                ),
            ),
        ),
        Pose((0.03, 0.0, -0.38)),
    )
    hip = Coordinate("hip", -1.2, 1.5, 0.3, damping=0.2, armature=0.01)
    toe = Coordinate("toe", -1.0, 1.0, 0.4, locked=True)
    muscles = (
        Muscle(
            "quadriceps",
            (
                ViaPoint(WORLD, (0.05, 0.0, 0.1)),
                ViaPoint("thigh", (0.06, 0.0, -0.2)),
                ViaPoint("kneecap", (0.03, 0.0, 0.02)),
                ViaPoint("shank", (0.04, 0.0, -0.08)),
            ),
            f_max=800.0,
        ),
        Muscle(
            "hamstring",
            (ViaPoint(WORLD, (-0.06, 0.0, 0.0)), ViaPoint("shank", (-0.03, 0.01, -0.05))),
            f_max=600.0,
        ),
        Muscle(
            "side",
            (ViaPoint("thigh", (0.0, 0.06, -0.2)), ViaPoint("foot", (0.0, 0.05, -0.02))),
            f_max=300.0,
        ),
    )
    return Robot(
        "leg",
        (Link("thigh", body), Link("shank", body), Link("kneecap", small), Link("foot", small)),
        (
            Joint("hip_joint", WORLD, "thigh", revolute((0.0, 1.0, 0.0)), (hip,)),
            knee,
            patella,
            Joint(
                "toe_joint",
                "shank",
                "foot",
                revolute((0.0, math.sqrt(0.5), math.sqrt(0.5))),
                (toe,),
                Pose((0.0, 0.0, -0.4)),
            ),
        ),
        (CableSet("all", muscles),),
        "all",
        (
            TaskSet(
                "ends",
                (
                    TaskFrame("tip", "foot", (0.1, 0.0, -0.05)),
                    TaskFrame("cap", "kneecap", (0.01, 0.02, 0.0)),
                    TaskFrame("turned", "foot", axes=("alpha", "beta", "gamma")),
                ),
            ),
        ),
        "ends",
    )
