"""Random failures of Roboy's arm on the emulated device: found, isolated, delay; false alarms.

CARDSFLOW_FAULTS: number of failures (default: 20). CARDSFLOW_QUIET: seconds with payloads and
contacts, but without failures (default: 20). CARDSFLOW_DRIFT: seconds in which three lengths drift
by 5 mm in 10 minutes (default: 20).
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

from cardsflow_fmu.experiment.settings.hardware import FailureSettings

NUMBER = int(os.environ.get("CARDSFLOW_FAULTS", "20"))
QUIET = float(os.environ.get("CARDSFLOW_QUIET", "20"))
DRIFT = float(os.environ.get("CARDSFLOW_DRIFT", "20"))
RATES = {"motor2": 5e-3 / 600, "motor5": -5e-3 / 600, "motor9": 5e-3 / 600}  # in [m/s]
MAX_WAIT = 5.6  # in [s]
FLOWER = (2.5, 26.0)  # times at which runs begin, in [s]


@pytest.mark.parametrize(("has_tensions", "max_delay"), [(True, 0.03), (False, 0.1)])
def test_random_failures_are_found_and_isolated(has_tensions: bool, max_delay: float) -> None:
    arm, random = FaultyArm(has_tensions=has_tensions), np.random.default_rng(12)
    kinds = ["off_pulley", *KINDS[1:]]
    if not has_tensions:
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


@pytest.mark.parametrize("has_tensions", [True, False])
def test_payloads_and_contacts_cause_no_false_alarm(has_tensions: bool) -> None:
    assert run_with_loads(FaultyArm(has_tensions=has_tensions), QUIET, seed=4) == 0


@pytest.mark.parametrize("drift", [2e-5, 0.0])
@pytest.mark.parametrize("encoder_noise", [1e-4, 2e-3])
def test_drifting_lengths_with_and_without_estimated_offsets(
    drift: float, encoder_noise: float
) -> None:
    """The monitor watches only an arm with estimated offsets. Then a length jumps by 3 mm."""
    arm = FaultyArm(
        encoder_noise=encoder_noise, load_drift=0.1, acceleration_noise=3.0, offset_drift=drift
    )
    own = [
        FailureSettings(kind="length_drift", part=part, time=2.0, value=rate)
        for part, rate in RATES.items()
    ]
    own.append(FailureSettings(kind="length_bias", part="motor2", time=DRIFT, value=3e-3))
    arm.reset(1, tuple(own))
    arm.is_monitored = drift > 0.0
    errors, valid, end = [], 0, round(DRIFT / STEP)
    for tick in range(end):
        if arm.time > 32.0:  # the flower is closed, and ends at rest
            arm.time -= 30.0
        if tick * STEP >= 2.0:
            wanted = np.ravel(np.array(arm.reference(arm.time)))[:3]
            errors.append(np.linalg.norm(arm.device.plant.task_position - wanted))
        assert not arm.tick(), arm.found
        valid += arm.estimator.valid
    rms = float(np.sqrt(np.mean(np.square(errors))))
    print(
        f"encoders {1e3 * encoder_noise:g} mrad, offset_drift {drift:g}: hand RMS {1e3 * rms:.3f}, "
        f"largest {1e3 * max(errors):.2f} mm, valid {valid / end:.1%}"
    )
    if drift == 0.0:
        return
    true = np.array([RATES.get(name, 0.0) for name in arm.muscles]) * (DRIFT - 2.0)
    off = arm.estimator.offset_changes - true
    print(f"offsets: largest error {1e3 * np.abs(off).max():.3f} mm")
    assert rms < 1e-3
    assert valid == end
    assert (np.abs(off) < 4.5 * arm.estimator.sd[-arm.m :]).all()
    while not arm.tick() and arm.ticks < end + 100:
        pass
    assert arm.found == {("length_bias", "length.motor2")}
