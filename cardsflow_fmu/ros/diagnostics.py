"""Warnings and controller status of a run as ROS diagnostics."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from cardsflow_fmu.results.estimation import describe_event, fault_events
from cardsflow_fmu.results.run_data import RunData
from cardsflow_fmu.ros_interface import message_types as types
from cardsflow_fmu.ros_interface.node import Topic, header

from .topics import Batch, nanoseconds

TOPIC = Topic("/diagnostics", types.DIAGNOSTICS)

_OK, _WARN, _ERROR = 0, 1, 2
_FAULTS = {
    "infeasible": (_ERROR, "infeasible: no forces within the limits produce the desired torques"),
    "not_converged": (_WARN, "not converged: the force distribution found no solution"),
    "fallback": (_WARN, "no predicted motion was found; the computed torque determines the forces"),
    "limits_dropped": (_WARN, "no forces within the limits keep the joint limits"),
}


def run_diagnostics(run: RunData) -> Iterator[Batch]:
    """Yield the diagnostics of a run.

    The first message contains the warnings of the run. A message follows for each detected fault
    and each decision about it. If the run has columns with controller faults, a message contains
    their state at the beginning and after each change.
    """
    if not len(run.rows):
        return
    time_ns = nanoseconds(run["time"])
    lines = [str(line) for line in run.summary.get("warnings") or ()]
    if run.summary.get("status") == "incomplete":
        lines.append(f"incomplete run: {run.summary.get('error')}")
    status = _status("run", _WARN if lines else _OK, "; ".join(lines) or "complete", {})
    yield _message(time_ns[:1], [status])
    for event in fault_events(dict(zip(run.names, run.rows.T, strict=True))):
        row = int(np.searchsorted(run["time"], event["time"]))
        values = {key: str(value) for key, value in event.items()}
        status = _status("faults", _ERROR, describe_event(event), values)
        yield _message(time_ns[row : row + 1], [status])
    recorded = [name for name in _FAULTS if name in run.names]
    slack = [name for name in run.names if name.startswith("slack.")]
    faults = np.nan_to_num(run.columns(recorded)) != 0.0 if recorded else np.zeros((0, 0))
    changes = np.flatnonzero((faults[1:] != faults[:-1]).any(axis=1)) + 1
    for k in [0, *changes.tolist()] if recorded else []:
        flags = faults[k].tolist()
        active = [_FAULTS[name] for name, is_set in zip(recorded, flags, strict=True) if is_set]
        shortfall = {name: repr(float(run[name][k])) for name in slack} if active else {}
        level = max((level for level, _ in active), default=_OK)
        text = "; ".join(line for _, line in active) or "feasible"
        yield _message(time_ns[k : k + 1], [_status("controller", level, text, shortfall)])


def _status(name: str, level: int, text: str, values: dict[str, str]) -> dict[str, object]:
    rows = [{"key": key, "value": value} for key, value in values.items()]
    return {"level": level, "name": f"cardsflow: {name}", "message": text, "values": rows}


def _message(time_ns: NDArray[np.int64], status: list[dict[str, object]]) -> Batch:
    return Batch(TOPIC, time_ns, {"header": header(time_ns), "status": status})
