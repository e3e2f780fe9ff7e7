"""Random failures of Roboy's arm on the emulated device: found, isolated, delay; false alarms.

CARDSFLOW_FAULTS: number of failures (default: 20). CARDSFLOW_QUIET: seconds with payloads and
contacts, but without failures (default: 20).
"""

from __future__ import annotations

import os
from collections import defaultdict

import numpy as np
import pytest
from support.controllers.fault_monitor import KINDS, STEP
from support.hardware.faulty_arm import (
    FaultyArm,
    expected_fault,
    random_failure,
    run_with_loads,
)

NUMBER = int(os.environ.get("CARDSFLOW_FAULTS", "20"))
QUIET = float(os.environ.get("CARDSFLOW_QUIET", "20"))
MAX_WAIT = 5.6  # in [s]
FLOWER = (2.5, 26.0)  # times at which runs begin, in [s]


@pytest.mark.parametrize(("has_tensions", "max_delay"), [(True, 0.03), (False, 0.1)])
def test_random_failures_are_found_and_isolated(has_tensions: bool, max_delay: float) -> None:
    arm, random = FaultyArm(has_tensions=has_tensions), np.random.default_rng(12)
    kinds = ["off_pulley", *KINDS[1:]]
    if not has_tensions:  # a motor is only compared with the measured tension
        kinds = [kind for kind in kinds if kind not in ("broken", "jammed", "weak")]
        kinds = [kind for kind in kinds if not kind.startswith("tension")]
    moments = []
    while arm.time < FLOWER[1]:
        arm.tick()
        moments.append(arm.moment)
    moments = [moment for moment in moments if moment.time > FLOWER[0]]
    delays: dict[str, list[float]] = defaultdict(list)
    for number in range(NUMBER):
        failure = random_failure(arm, random, kinds)
        arm.reset(number, (failure,), moments[random.integers(len(moments))])
        while not arm.tick() and arm.ticks * STEP < MAX_WAIT:
            pass
        was_found = expected_fault(failure) in arm.found
        delay = (arm.ticks - 1) * STEP - failure.time
        delays[failure.kind].append(delay if was_found else np.inf)
        if not was_found:
            print("missed:", failure, "found:", arm.found, f"{1e3 * delay:.0f} ms")
    for kind, own in sorted(delays.items()):
        print(f"{kind:15} {np.isfinite(own).sum()} of {len(own)}, median {np.median(own):.4f} s")
    every = np.concatenate(list(delays.values()))
    print(f"found {np.isfinite(every).sum()} of {NUMBER}, median delay {np.median(every):.4f} s")
    assert np.isfinite(every).sum() >= 0.95 * NUMBER
    assert np.median(every) <= max_delay


def test_payloads_and_contacts_cause_no_false_alarm() -> None:
    assert run_with_loads(FaultyArm(), QUIET, seed=4) == 0
