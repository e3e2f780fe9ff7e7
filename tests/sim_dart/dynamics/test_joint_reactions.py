"""Forces and moments of joints."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import read_robot
from sim_dart import CoreDynamics
from sim_dart.dynamics.joint_reactions import joint_reactions

STATE = {
    "pelvis_tilt": (0.12001940000277964, 0.3, 0.24454531403270607),
    "pelvis_tx": (0.06768549000027796, 0.4, 0.032572886169864645),
    "pelvis_ty": (1.070046670000278, 0.5, -10.02142992291715),
    "hip_flexion_r": (-0.07539923998449646, 0.6, -1.263144074992586),
    "knee_angle_r": (-0.5469763000891985, 0.7, 2.7693158958325714),
    "ankle_angle_r": (0.19735134000277962, 0.9, -8.510178201769264),
}
OPENSIM = {
    "hip_r": (
        (-0.08864510163437611, 0.01371544551563314, -0.0012017299000996289),
        (-0.4446159793998268, 2.4941883621657723, 0.12501970406231688),
    ),
    "knee_r": (
        (-0.004912739430038504, 0.017207962225713275, -0.024474390405722746),
        (0.8606546501422301, 3.106699327010219, 0.1542681919697212),
    ),
    "ankle_r": (
        (-0.00037116497338361004, 0.014862513426716586, 0.0013192704393346043),
        (0.4706003255960005, 1.0458212578913333, -0.028809699731762173),
    ),
}
"""Moments and forces of Joint.calcReactionOnChildExpressedInGround of OpenSim 4.6 at STATE, for
leg6dof9musc.osim without muscle forces."""


def test_reactions_match_opensim(shared: Path) -> None:
    robot = read_robot(shared / "models/opensim/leg6dof9musc.osim")
    rows = np.array([STATE[c.name] for c in robot.coordinates]).T[:, None, :]
    found = joint_reactions(robot, tuple(rows), np.zeros((1, len(robot.muscles))))  # type: ignore[arg-type]
    for name, values in OPENSIM.items():
        k = found.joints.index(name)
        np.testing.assert_allclose(found.moments[0, k], values[0], atol=1e-9)
        np.testing.assert_allclose(found.forces[0, k], values[1], atol=1e-7)


def test_moments_about_joint_axes_are_the_torques_of_inverse_dynamics() -> None:
    robot, rng = read_robot(EXAMPLES / "hill_arm/robot"), np.random.default_rng(0)
    dynamics, n = CoreDynamics(robot), len(robot.coordinates)
    q, qd, qdd = rng.uniform(0.2, 1.0, (3, 4, n))
    f = rng.uniform(0.0, 300.0, (4, len(robot.muscles)))
    loads = ("forearm",), rng.normal(size=(4, 1, 3)), rng.normal(size=(4, 1, 3))
    without = joint_reactions(robot, (q, qd, qdd), f)
    found = joint_reactions(robot, (q, qd, qdd), f, loads)
    for k in range(4):
        tau = dynamics.mass_matrix(q[k]) @ qdd[k] + dynamics.coriolis(q[k], qd[k])
        tau += dynamics.gravity(q[k]) + dynamics.muscle_jacobian(q[k]).T @ f[k]
        np.testing.assert_allclose(-without.moments[k, :, 1], tau, atol=1e-9)  # the axes are -y
    np.testing.assert_allclose(found.forces - without.forces, -np.repeat(loads[1], 2, axis=1))
