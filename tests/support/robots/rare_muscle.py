"""A muscle with all rare properties of points, wraps and muscles."""

from addin_sdfusion.robot import (
    BasePulley,
    Branch,
    CoordinateTerm,
    Muscle,
    PointCondition,
    PointMotion,
    Polynomial,
    SimmSpline,
    ViaPoint,
    Wrap,
)

RARE = Muscle(
    "rare",
    (
        ViaPoint("upper", (0.1, -0.0, 1e-17), friction=0.2),
        ViaPoint(
            "upper",
            (0.1, 0.2, 0.3),
            PointCondition("elbow", -0.5, 1.0, 0.1),
            (
                PointMotion((1.0, 0.0, 0.0), "elbow", Polynomial((0.0, 0.5)), high=2.0),
                PointMotion((0.0, 1.0, 0.0), "elbow", SimmSpline((0.0, 1.0), (2.0, 3.0))),
            ),
        ),
        ViaPoint("world", (0.0, 0.0, 1.0)),
        ViaPoint("world", (0.0, 0.0, 2.0)),
    ),
    pulley=BasePulley(
        "rotating", (("pulley_radius", (0.02,)), ("cable_entry_vector", (0.0, 0.0, 1.0)))
    ),
    wraps=(
        Wrap("a", 0, 0, 0, True),
        Wrap("a", 1, 1, 2, friction=0.5),
        Wrap("b", 1, rule="mujoco", side_point=ViaPoint("upper", (1.0, 2.0, 3.0))),
        Wrap("b", 2, rule="opensim", quadrant="-y", last_segment=3),
    ),
    branches=(Branch(0, 2.0), Branch(2, 3.0)),
    terms=(CoordinateTerm("elbow", 0.03),),
    friction=0.1,
    presliding=1e-3,
)
