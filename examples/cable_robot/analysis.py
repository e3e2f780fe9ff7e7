"""Wrench-feasible workspace, stiffness and tension distributions of the cable robot."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from addin_sdfusion.robot import read_robot
from controllers.analysis.stiffness import stiffness
from controllers.analysis.workspace import joint_grid, workspace
from controllers.force_distribution.methods import distribute
from sim_dart import MusclePaths, control_dynamics

HERE = Path(__file__).parent
LOADS = [30.0, 30.0, 30.0, 1.0, 1.0, 1.0]  # [N] along x, y, z, [N m] about them, both ways
NORMS = {
    "linear_programme": "1: least sum",
    "least_squares": "2: least sum of squares",
    "minimum_infinity_norm": "infinity: least largest",
    "closed_form": "2, about the middle of the bounds",
    "polygon_centroid": "centroid of all that fit",
    "optimally_safe": "farthest from the bounds",
}
CABLE = 1e5  # EA, [N]
BEHIND = 2.0  # cable between drum and pulley, [m]

robot = read_robot(HERE / "robot")
dynamics, paths = control_dynamics(robot), MusclePaths(robot)


def draw(file: Path) -> None:
    """Draw the vertical section at y = 0: the wrench-feasible poses and their torque margin."""
    poses = joint_grid([-1.5, 0, 0.2, 0, 0, 0], [1.5, 0, 2.3, 0, 0, 0], [31, 1, 22, 1, 1, 1])
    section = workspace(
        dynamics,
        poses,
        conditions=["wrench_closure", "static", "wrench_feasible"],
        metrics=["capacity_margin"],
        loads=LOADS,
    )
    for name in section.conditions:
        print(f"{name:16} {100 * section.share(name):5.1f} % of the section")
    x, z = poses[:, 0, 0, 0, 0, 0, 0], poses[0, 0, :, 0, 0, 0, 2]
    holds = section.conditions["wrench_feasible"].reshape(len(x), len(z))
    margin = section.metrics["capacity_margin"].reshape(len(x), len(z))
    figure = Figure(figsize=(7, 4.5), layout="constrained")
    axes = figure.subplots()
    drawn = axes.pcolormesh(x, z, np.where(holds, margin, np.nan).T, cmap="viridis")
    figure.colorbar(drawn, label="margin of the torques [N]")
    axes.set(xlabel="x [m]", ylabel="z [m]", aspect="equal", title="wrench-feasible, level, y = 0")
    figure.savefig(file, dpi=120)


def compare(q: np.ndarray, load: np.ndarray) -> None:
    """Print force distributions that balance a load on the platform, and the stiffness of each."""
    L, tau, lengths = (
        dynamics.muscle_jacobian(q),
        dynamics.gravity(q) + load,
        paths.evaluate(q).lengths,
    )
    print(f"\nat {q[:3]} m, against {load}")
    print(f"{'':36} least [N]  largest [N]  sum [N]  least stiffness [N/m]")
    for method, norm in NORMS.items():
        distribution = distribute(L, tau, dynamics.f_min, dynamics.f_max, method)
        if not distribution.solved:
            print(f"  {norm:34} {distribution.status}")
            continue
        f = distribution.forces
        K = stiffness(dynamics, q, f, muscle_stiffness=CABLE / (lengths + BEHIND)).total
        least = np.linalg.eigvalsh(K[:3, :3])[0]
        print(f"  {norm:34} {f.min():9.1f} {f.max():12.1f} {f.sum():8.1f} {least:22.0f}")


draw(Path(sys.argv[1] if len(sys.argv) > 1 else "workspace.png"))
middle = np.array([0.0, 0.0, 1.1, 0.0, 0.0, 0.0])
compare(middle, np.zeros(6))
compare(middle, np.array([0.0, 0.0, 0.0, 10.0, 10.0, 20.0]))
compare(np.array([0.8, 0.4, 1.5, 0.0, 0.0, 0.1]), np.zeros(6))
