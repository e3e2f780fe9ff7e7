"""Mass matrices and bias forces compared with values of OpenSim 4.6 and MuJoCo 4.0.

Couplings are eliminated. If three rotations of a joint depend on one coordinate, the bias of
OpenSim
contradicts its mass matrix, since the term f2' f3' (R1 a2 x R1 R2 a3) u² of the angular
acceleration
is missing. In this case Lagrange's equations with OpenSim's M are the reference.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from addin_sdfusion.robot import Coordinate, Robot
from addin_sdfusion.robot.formats.read import read
from sim_dart.core.arrays import FloatArray
from sim_dart.dynamics.core import CoreDynamics

OPENSIM = ("arm26", "leg6dof9musc", "gait10dof18musc", "gait2392_thelen2003muscle")
MUJOCO = ("myoelbow_2dof6muscles", "myofinger_v0", "myohand", "myoarm")
TOLERANCE = 1e-12
"""Tolerance relative to the largest entry; the measured error is 3e-14."""


def bodies_only(file: Path) -> Robot:
    """Return the model without muscles, joint forces and locks."""

    def bare(c: Coordinate) -> Coordinate:
        words: dict[str, Any] = {"stiffness": 0.0, "friction": 0.0, "limit_force": None}
        return replace(c, locked=False, **words)

    robot = read(file).robot
    assert robot is not None
    joints = (replace(j, coordinates=tuple(map(bare, j.coordinates))) for j in robot.joints)
    return replace(robot, cable_sets=(), cable_set="", wrap_surfaces=(), joints=tuple(joints))


def largest_errors(
    dynamics: CoreDynamics, names: list[str], full: list[str], poses: list[dict[str, Any]],
    q: str, u: str,
) -> tuple[float, float]:  # fmt: skip
    """Return the errors of M and C + G relative to their largest entries."""
    own = list(dynamics.coordinate_names)
    order = [own.index(name) for name in names]
    assert len(order) == len(own)
    off = np.zeros((len(poses), 2))
    for k, pose in enumerate(poses):
        at, rates = dict(zip(full, pose[q], strict=True)), dict(zip(full, pose[u], strict=True))
        here, speed = [at[name] for name in own], [rates[name] for name in own]
        M = dynamics.mass_matrix(here)[np.ix_(order, order)]
        bias = (dynamics.coriolis(here, speed) + dynamics.gravity(here))[order]
        pairs = (M, "M"), (bias, "bias")
        for i, (found, field) in enumerate(pairs):
            expected = np.array(pose.get(f"{field}_reduced", pose[field]))
            off[k, i] = np.abs(found - expected).max() / np.abs(expected).max()
    largest: FloatArray = off.max(axis=0)
    return float(largest[0]), float(largest[1])


def opensim(shared: Path, model: str) -> tuple[CoreDynamics, float, float]:
    numbers = json.loads((shared / f"reference/opensim/{model}.json").read_text())
    dynamics = CoreDynamics(bodies_only(shared / f"models/opensim/{model}.osim"))
    every = numbers["coordinates"]
    free = [c["name"] for c in every if not c["dependent_on"]]
    return dynamics, *largest_errors(
        dynamics, free, [c["name"] for c in every], numbers["poses"], "q", "u"
    )


@pytest.mark.parametrize("model", OPENSIM)
def test_opensim(shared: Path, model: str) -> None:
    _, M, bias = opensim(shared, model)
    assert M < TOLERANCE
    assert bias < TOLERANCE


@pytest.mark.slow
def test_opensim_where_three_rotations_follow_one_coordinate(shared: Path) -> None:
    dynamics, M, bias = opensim(shared, "subject_walk_scaled")
    assert M < TOLERANCE
    assert 1e-5 < bias < 1e-4
    n, h = dynamics.n, 2e-4
    rng = np.random.default_rng(1)
    q, u = rng.uniform(0.2, 1.0, n), rng.uniform(-1.0, 1.0, n)

    def slopes(step: float) -> FloatArray:
        ends = ((dynamics.mass_matrix(q + step * e), dynamics.mass_matrix(q - step * e))
                for e in np.eye(n))  # fmt: skip
        return np.stack([(a - b) / (2 * step) for a, b in ends], axis=-1)

    dM = (4 * slopes(h / 2) - slopes(h)) / 3
    C = np.einsum("kji,i,j->k", dM, u, u) - 0.5 * np.einsum("ijk,i,j->k", dM, u, u)
    np.testing.assert_allclose(dynamics.coriolis(q, u), C, atol=1e-11 * np.abs(C).max() + 1e-8)


@pytest.mark.parametrize("model", MUJOCO)
def test_mujoco(shared: Path, model: str) -> None:
    numbers = json.loads((shared / f"reference/mjcf/{model}.json").read_text())
    dynamics = CoreDynamics(bodies_only(shared / f"models/mjcf/{model}.xml"))
    dofs = [dof["joint"] if isinstance(dof, dict) else dof for dof in numbers["dofs"]]
    poses = numbers["poses"]
    free = [dofs[d] if isinstance(d, int) else d for d in poses[0].get("independent_dofs", dofs)]
    M, bias = largest_errors(dynamics, free, dofs, poses, "qpos", "qvel")
    assert M < TOLERANCE
    assert bias < TOLERANCE
