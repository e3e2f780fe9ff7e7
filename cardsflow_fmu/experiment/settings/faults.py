"""Settings of [faults]: detection of faults of cables, motors and sensors."""

from __future__ import annotations

from cardsflow_fmu.experiment.config.names import named_setting
from cardsflow_fmu.experiment.config.table import Context, FromZero, Positive, Table, setting

from .estimator import EstimatorTable

MAX_DELAY = 60
"""Maximum delay of measurements for the detection of faults, in steps."""


class FaultsTable(Table):
    """Detection of faults: accepted false alarms, and errors of healthy sensors and motors."""

    use: bool = setting("detect faults in runs", True)
    false_alarms_per_hour: Positive = setting(
        "mean number of false alarms per hour, which determines all thresholds", 0.1
    )
    length_error: tuple[FromZero, ...] = named_setting(
        "muscle", "standard deviation of constant errors of the model's lengths, in m", 2e-4
    )
    tension_noise: tuple[FromZero, ...] = named_setting(
        "muscle", "standard deviation of the tension measurement, in N", 0.5
    )
    tension_error: tuple[FromZero, ...] = named_setting(
        "muscle", "relative standard deviation of the tension measurement", 0.05
    )
    load_noise: tuple[FromZero, ...] = named_setting(
        "coordinate", "noise density of slow changes of unknown loads, in N·m/√s or N/√s", 0.05
    )
    load_change: tuple[FromZero, ...] = named_setting(
        "coordinate",
        "standard deviation of sudden changes of unknown loads, in N·m or N; without tension "
        "sensors, lost forces are detected by the motion; 0: they are not",
        3.0,
    )
    motor_lag: FromZero = setting("time constant of the motors, in s", 0.0)
    react: bool = setting(
        "react to lost muscles: continue, slow down, hold the pose or stop the joints; false: only "
        "detect and report faults",
        True,
    )
    ramp: FromZero = setting("duration of changes of the reference's speed, in s", 0.5)


def read_faults(
    data: object, context: Context, estimator: EstimatorTable | None, step: float
) -> FaultsTable | None:
    """Read the table [faults]; return None if it does not exist or is not used."""
    if data is None:
        return None
    settings = FaultsTable.read(data, context, "faults")
    if not settings.use:
        return None
    if estimator is None:
        problem = "requires an estimator; add [estimator], or remove [faults]"
        raise context.error("faults", problem)
    if estimator.delay(step) > MAX_DELAY:
        problem = f"must be at most {MAX_DELAY} steps of {step!r} s to detect faults"
        raise context.error("estimator.sensors.delay", problem)
    return settings
