"""Detected faults and decisions in the summary, its text, and ROS diagnostics."""

from __future__ import annotations

import numpy as np

from cardsflow_fmu.results.estimation import describe_event, fault_events
from cardsflow_fmu.results.run_data import RunData
from cardsflow_fmu.ros.diagnostics import run_diagnostics

TIMES = np.arange(6) * 0.5


def columns() -> dict[str, np.ndarray]:
    """Return a broken cable at 1 s, a decision in the same step, and a biased sensor at 2 s."""
    return {
        "time": TIMES,
        "fault.motor4": np.array([0.0, 0, 1, 1, 1, 1]),
        "fault.motor5": np.zeros(6),
        "length_fault.motor1": np.array([0.0, 0, 0, 0, 5, 5]),
        "fault_confidence": np.array([0.0, 0, 0.999, 0.999, 0.98, 0.98]),
        "fault_statistic": np.array([0.0, 0, 41, 41, 30, 30]),
        "reaction": np.array([0.0, 0, 2, 2, 2, 3]),
        "reference_speed": np.array([1.0, 1, 0.5, 0.5, 0.5, 0]),
    }


def test_events_are_in_the_order_of_time() -> None:
    texts = [describe_event(event) for event in fault_events(columns())]
    assert texts == [
        "at 1 s muscle motor4: broken (confidence 99.9%)",
        "at 1 s decision: slow down to 50% of the speed",
        "at 2 s length sensor motor1: length bias (confidence 98.0%)",
        "at 2.5 s decision: hold the pose",
    ]


def test_events_contain_the_evidence() -> None:
    first = fault_events(columns())[0]
    assert first == {
        "time": 1.0,
        "part": "muscle motor4",
        "kind": "broken",
        "statistic": 41.0,
        "confidence": 0.999,
    }


def test_columns_without_faults_have_no_events() -> None:
    assert fault_events({"time": TIMES, "fault.a": np.zeros(6), "reaction": np.zeros(6)}) == []


def test_diagnostics_contain_the_events() -> None:
    names, rows = tuple(columns()), np.stack(list(columns().values()), axis=1)
    messages = list(run_diagnostics(RunData(names, rows, {}, {})))
    status = [batch.values["status"][0] for batch in messages]
    faults = [one for one in status if one["name"] == "cardsflow: faults"]
    assert [one["level"] for one in faults] == [2] * 4
    assert faults[0]["message"] == "at 1 s muscle motor4: broken (confidence 99.9%)"
    assert {"key": "confidence", "value": "0.999"} in faults[0]["values"]
