"""Variables of sensors and estimators."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.model.muscle_laws import law_of
from sim_dart.estimation.estimator import STATUSES

from .groups import Groups
from .muscles import is_modelled
from .port import (
    Causality,
    Port,
    coordinate_signals,
    count_port,
    motor_ports,
    motor_signals,
    muscle_ports,
    muscle_signals,
    signal_names,
    time_port,
)
from .ports import TORQUE, WORKER_TIMEOUT, coordinate_ports, force_unit

LENGTH, TENSION, MOTOR_TORQUE, POSITION = "l", "tension", "torque", "q"
"""Prefixes of measurements as inputs of the estimator and outputs of hardware."""
MEASURED = "_m"
"""Suffix of measurements of simulated sensors, which differ from the true values."""
ESTIMATE = {"q": "q_hat", "qd": "qd_hat", "w": "w_hat", "sd": "sd"}
"""Prefixes of the estimator's outputs."""
OFFSET, OFFSET_SD = "offset_hat", "offset_sd"
"""Prefixes of the estimated length offsets and their standard deviations."""
VALID = "valid"


def measured_muscles(robot: Robot) -> list[int]:
    """Return the indices of the muscles with a motor, which have sensors."""
    return [k for k, muscle in enumerate(robot.muscles) if law_of(muscle.model).command is not None]


def _measurement_ports(
    robot: Robot, encoded: Sequence[int], units: Sequence[str], causality: Causality, mark: str
) -> Groups:
    """Return the ports of all measurements, with a suffix of the prefixes."""
    muscles = measured_muscles(robot)
    positions = coordinate_signals(POSITION + mark, robot)
    return {
        "lengths": muscle_ports(
            LENGTH + mark, "m", "Measured length of muscle", robot, causality, muscles
        ),
        "measured_tensions": muscle_ports(
            TENSION + mark, "N", "Measured tension of muscle", robot, causality, muscles
        ),
        "measured_torques": motor_ports(
            MOTOR_TORQUE + mark, "Measured torque of", robot, causality
        ),
        "encoders": [
            Port(positions[j], c.unit, causality, "continuous", f"Measured position of {c.name}")
            for j, c in enumerate(robot.coordinates)
            if j in encoded
        ],
        **imu_ports(units, causality),
    }


def imu_ports(units: Sequence[str], causality: Causality) -> Groups:
    """Return three ports for the gyroscope and three for the accelerometer of each IMU."""
    return {
        group: [
            Port(f"{name}.{axis}", unit, causality, "continuous", f"{title} of {link} along {axis}")
            for name, link in zip(signal_names(prefix, units), units, strict=True)
            for axis in "xyz"
        ]
        for group, prefix, unit, title in (
            ("gyroscopes", "gyroscope", "rad/s", "Measured angular velocity"),
            ("accelerometers", "accelerometer", "m/s2", "Measured specific force"),
        )
    }


def sensor_groups(robot: Robot, encoded: Sequence[int], units: Sequence[str]) -> Groups:
    """Return the variables of sensors.

    Inputs are the true state, tensions and torques; outputs are the measurements.
    """
    return {
        **{
            prefix: coordinate_ports(prefix, per, quantity, robot, "input", "continuous")
            for prefix, per, quantity in (("q", "", "Position"), ("qd", "/s", "Velocity"))
        },
        "tensions": muscle_ports(
            TENSION, "N", "Tension of", robot, "input", measured_muscles(robot)
        ),
        "torques": motor_ports(MOTOR_TORQUE, "Torque of the motor of", robot, "input"),
        **_measurement_ports(robot, encoded, units, "output", MEASURED),
        "worker_timeout": [WORKER_TIMEOUT],
    }


def estimator_groups(
    robot: Robot,
    encoded: Sequence[int],
    units: Sequence[str],
    q: Sequence[float],
    offsets: Sequence[float],
    step: float,
    *,
    estimates_offsets: bool = False,
) -> Groups:
    """Return the variables of an estimator.

    Inputs are measurements; outputs are state, loads and validity.

    Args:
        encoded: Coordinates with an encoder.
        units: Links with an IMU.
        q: Start pose, or initial guess for the search of the start pose, in [rad] or [m].
        offsets: Offsets of the measured lengths, one per muscle, in [m].
        step: Internal step, in [s].
        estimates_offsets: Whether the offsets are estimated.
    """
    statuses = ", ".join(f"{number} {text}" for number, text in enumerate(STATUSES))
    return {
        **_measurement_ports(robot, encoded, units, "input", ""),
        **_estimate_ports(robot),
        "report": [
            count_port("innovation", "Mean square of normalised innovations"),
            count_port("readings", "Number of measurements used"),
            count_port("status", f"State of the estimator: {statuses}", len(STATUSES) - 1),
            Port(VALID, "", "output", "discrete", "The estimate is reliable", boolean=True),
        ],
        "q_start": coordinate_ports(
            "q_start", "", "Start position", robot, "parameter", "fixed", q
        ),
        **_offset_ports(robot, offsets, estimates_offsets),
        "step": [time_port("step", "Internal step of the estimator", step)],
        "worker_timeout": [WORKER_TIMEOUT],
    }


def _estimate_ports(robot: Robot) -> Groups:
    """Return position, velocity, unknown load and standard deviation of each coordinate."""
    descriptions = (
        ("q", "", "Estimated position"),
        ("qd", "/s", "Estimated velocity"),
        ("w", None, "Estimated unknown load"),
        ("sd", "", "Standard deviation of the estimated position"),
    )
    return {
        key: [
            Port(
                name,
                force_unit(c) if per is None else c.unit + per,
                "output",
                "continuous",
                f"{quantity} of {c.name}",
            )
            for name, c in zip(
                coordinate_signals(ESTIMATE[key], robot), robot.coordinates, strict=True
            )
        ]
        for key, per, quantity in descriptions
    }


def _offset_ports(robot: Robot, offsets: Sequence[float], estimates_offsets: bool) -> Groups:
    """Return the length offsets as parameters, and their estimates as outputs."""
    muscles, quantity = measured_muscles(robot), "Offset of the measured length of muscle"
    starts = muscle_ports("offset", "m", quantity, robot, "parameter", muscles, "fixed")
    return {
        "offsets": [
            replace(port, start=offsets[k]) for k, port in zip(muscles, starts, strict=True)
        ],
        **{
            group: muscle_ports(prefix, "m", f"{quantity} of muscle", robot, "output", muscles)
            if estimates_offsets
            else []
            for group, prefix, quantity in (
                ("found_offsets", OFFSET, "Estimated offset of the measured length"),
                ("offset_sd", OFFSET_SD, "Standard deviation of the estimated offset"),
            )
        },
    }


def estimate_inputs(robot: Robot) -> Groups:
    """Return the inputs of a controller from an estimator in addition to the state."""
    is_valid = "The state is reliable; otherwise commands ramp down"
    return {
        "estimated_loads": [replace(w, causality="input") for w in _estimate_ports(robot)["w"]],
        "valid": [Port(VALID, "", "input", "discrete", is_valid, 1.0, boolean=True)],
    }


def estimation_wiring(
    robot: Robot,
    encoded: Sequence[int],
    *,
    uses_estimate: bool,
    has_hardware: bool,
    has_tensions: bool = True,
    has_faults: bool = False,
) -> dict[str, str]:
    """Return the wiring for inputs of sensors, estimator and controller whose names differ.

    Args:
        encoded: Coordinates with an encoder.
        uses_estimate: Whether the controller uses the estimate.
        has_hardware: Whether measurements come from hardware instead of simulated sensors.
        has_tensions: Whether the hardware measures tensions and motor torques. Otherwise commands
            replace them.
        has_faults: Whether faults are detected, so that the plant provides all tensions.
    """
    muscles = measured_muscles(robot)
    wiring: dict[str, str] = {}
    forces, tensions = muscle_signals("f", robot), muscle_signals(TENSION, robot)
    motors = dict(
        zip(motor_signals(MOTOR_TORQUE, robot), motor_signals(TORQUE, robot), strict=True)
    )
    commanded = {tensions[k]: forces[k] for k in muscles if not is_modelled(robot.muscles[k])}
    commanded |= motors
    if not has_hardware:
        inputs = motors if has_faults else commanded
        wiring |= {f"sensors.{name}": f"controller.{out}" for name, out in inputs.items()}
        for group in _measurement_ports(robot, encoded, (), "input", "").values():
            for port in group:
                prefix, _, rest = port.name.partition(".")
                wiring[f"estimator.{port.name}"] = f"sensors.{prefix}{MEASURED}.{rest}"
    elif not has_tensions:
        wiring |= {f"estimator.{name}": f"controller.{out}" for name, out in commanded.items()}
    if uses_estimate:
        for key in ("q", "qd"):
            names = zip(
                coordinate_signals(key, robot),
                coordinate_signals(ESTIMATE[key], robot),
                strict=True,
            )
            wiring |= {f"controller.{target}": f"estimator.{name}" for target, name in names}
    return wiring
