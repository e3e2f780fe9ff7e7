"""External loads of OpenSim: measured forces on bodies, such as ground reaction forces."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from addin_sdfusion.robot import InputError, Robot, Subject, UnknownNameError
from addin_sdfusion.robot.formats.reading.xml import Node, Notes, parse
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.opensim_table import OpenSimTable, read_opensim_table
from controllers.analysis.inverse_dynamics import Motion
from sim_dart.dynamics.link_motion import link_motion

from .motion import ExternalLoads, GivenMotion

_LOAD, _GROUND = "ExternalForce", ("ground", "/ground")


def add_external_loads(recorded: GivenMotion, file: Path) -> GivenMotion:
    """Return a motion with the external loads of a file; errors as for `read_external_loads`."""
    if recorded.robot.loops:
        raise InputError("does not support closed kinematic loops", key="--loads")
    loads = read_external_loads(recorded.robot, recorded.motion, file)
    return replace(recorded, motion=replace(recorded.motion, w_e=-loads.generalised), loads=loads)


def read_external_loads(robot: Robot, motion: Motion, file: Path) -> ExternalLoads:
    """Read ExternalLoads of OpenSim, with their data file, at the times of a motion.

    Values between the rows of the data are interpolated linearly.

    Raises:
        InputError: A file is invalid, or does not cover the motion; the message names it.
    """
    root = parse(file, Subject("file", file.name), Notes())
    elements = [Node(each, file, root.subject, root.notes) for each in root.element.iter(_LOAD)]
    data = next((each.text or "" for each in root.element.iter("datafile")), "").strip()
    if not elements or not data:
        missing = "datafile" if elements else _LOAD
        raise InputError(f"has no {missing}; it must contain ExternalLoads of OpenSim", file=file)
    table = read_opensim_table(file.parent / data)
    _require_times(table, motion, file.parent / data)
    links = tuple(_link(robot, each) for each in elements)
    links_motion = link_motion(robot, links, motion.q, motion.qd, motion.qdd)
    forces, moments = np.zeros_like(links_motion.origins), np.zeros_like(links_motion.origins)
    for k, each in enumerate(elements):
        force, point, torque = (
            _columns(table, _text(each, f"{kind}_identifier"), motion.times, each)
            for kind in ("force", "point", "torque")
        )
        forces[:, k] = 0.0 if force is None else force
        moments[:, k] = 0.0 if torque is None else torque
        if point is not None:
            moments[:, k] += np.cross(point - links_motion.origins[:, k], forces[:, k])
    return ExternalLoads(links, forces, moments, links_motion.generalised_forces(forces, moments))


def _text(node: Node, tag: str) -> str:
    element = node.optional(tag)
    return "" if element is None else element.text


def _link(robot: Robot, load: Node) -> str:
    """Return the link of a load that is expressed in the ground frame."""
    for key in ("force_expressed_in_body", "point_expressed_in_body"):
        if (body := _text(load, key)) not in ("", *_GROUND):
            problem = f"{key} is {body!r}; express the load in ground"
            raise InputError(problem, file=load.file, line=load.line)
    body = _text(load, "applied_to_body").rpartition("/")[2]
    names = [link.name for link in robot.links]
    if body not in names:
        raise UnknownNameError("link", body, names, file=load.file, key="applied_to_body")
    return body


def _columns(
    table: OpenSimTable, identifier: str, times: FloatArray, load: Node
) -> FloatArray | None:
    """Return the three columns whose names begin with an identifier, shape (T, 3)."""
    if not identifier:
        return None
    columns = []
    for axis in "xyz":
        if f"{identifier}{axis}" not in table.names:
            name = f"{identifier}{axis}"
            raise UnknownNameError("column", name, table.names, file=load.file, key="datafile")
        column = table.rows[:, table.names.index(f"{identifier}{axis}")]
        columns.append(np.interp(times, table.rows[:, table.names.index("time")], column))
    return np.stack(columns, axis=1)


def _require_times(table: OpenSimTable, motion: Motion, file: Path) -> None:
    """Check that the rows of a table have increasing times that cover a motion."""
    if "time" not in table.names:
        raise UnknownNameError("column", "time", table.names, file=file)
    times = table.rows[:, table.names.index("time")]
    if not len(times) or (np.diff(times) <= 0.0).any():
        raise InputError("the times must increase from row to row", file=file)
    begin, end = float(motion.times[0]), float(motion.times[-1])
    if begin < times[0] or end > times[-1]:
        has = f"has loads from {times[0]:g} to {times[-1]:g} s"
        problem = f"{has}, but the motion is from {begin:g} to {end:g} s; use --begin and --end"
        raise InputError(problem, file=file)
