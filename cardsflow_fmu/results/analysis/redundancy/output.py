"""Results of the analysis of muscle redundancy: tables and summary."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from cardsflow_fmu.utils.opensim_table import opensim_text

from .static import Activations


def activation_files(result: Activations) -> dict[str, str]:
    """Return activations and forces as OpenSim tables, by file name."""
    reserves = [f"reserve_{name}" for name in result.coordinate_names]
    rows = np.column_stack([result.times, result.activations])
    forces = np.column_stack([result.times, result.forces, result.reserves])
    names = ["time", *result.muscle_names]
    files = {
        "activations.sto": opensim_text("activations", names, rows),
        "forces.sto": opensim_text("forces", [*names, *reserves], forces),
    }
    if (trajectory := result.trajectory) is not None:
        names = ["time", *result.trajectory_names]
        for name in ("excitations", "fibre_lengths", "fibre_rates"):
            rows = np.column_stack([result.times, getattr(trajectory, name)])
            files[f"{name}.sto"] = opensim_text(name, names, rows)
    return files


def activation_summary(result: Activations) -> dict[str, Any]:
    """Return a summary of activations as plain data."""
    largest = result.activations.max(axis=0, initial=0.0)
    reserves = np.abs(result.reserves).max(axis=0, initial=0.0)
    trajectory = result.trajectory
    return {
        "points": len(result.times),
        "begin": float(result.times[0]),
        "end": float(result.times[-1]),
        "infeasible": int(result.infeasible.sum()),
        "first_infeasible": float(result.times[result.infeasible][0])
        if result.infeasible.any()
        else None,
        "undriven": list(result.undriven),
        "largest_activations": dict(zip(result.muscle_names, largest.tolist(), strict=True)),
        "largest_reserves": dict(zip(result.coordinate_names, reserves.tolist(), strict=True)),
    } | (
        {}
        if trajectory is None
        else {
            "cost": trajectory.cost,
            "iterations": trajectory.iterations,
            "rigid": list(result.rigid_names),
        }
    )


def describe_activations(summary: Mapping[str, Any], count: int = 5) -> str:
    """Return the summary as lines of text, with the most activated muscles."""
    lines = []
    reserves = summary["largest_reserves"]
    if summary["infeasible"]:
        driven = {n: t for n, t in reserves.items() if n not in summary["undriven"]}
        name = max(driven, key=driven.__getitem__)
        lines.append(
            f"WARNING: the muscles are too weak at {summary['infeasible']} of {summary['points']} "
            f"points, from t = {summary['first_infeasible']:.4g} s; torque shortfall "
            f"{driven[name]:.3g} at {name}"
        )
    if summary.get("rigid"):
        names = ", ".join(summary["rigid"])
        lines.append(
            f"WARNING: tendons that are rigid, since short fibres leave them slack: {names}"
        )
    if summary["undriven"]:
        names = ", ".join(f"{n} {reserves[n]:.4g}" for n in summary["undriven"])
        lines.append(f"coordinates without muscles, with maximum reserve torque: {names}")
    lines.append(f"{summary['points']} points from {summary['begin']:g} to {summary['end']:g} s")
    if "cost" in summary:
        lines.append(f"cost {summary['cost']:.6g} after {summary['iterations']} iterations")
    ranked = sorted(summary["largest_activations"].items(), key=lambda item: -item[1])
    lines += [f"  {name}  up to {a:.4g}" for name, a in ranked[:count]]
    return "\n".join(lines)
