"""The device of an emulated robot."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cardsflow_fmu.experiment.settings.hardware import HardwareSettings, SensorSettings
from cardsflow_fmu.hardware.device.device import Device
from cardsflow_fmu.hardware.protocol.signals import hardware_signature

from .emulator import EmulatedRobot

if TYPE_CHECKING:
    from cardsflow_fmu.experiment.experiment import Experiment


def emulated_device(
    experiment: Experiment,
    settings: HardwareSettings,
    key: bytes | None = None,
    *,
    motor_lag: float | None = None,
    sensors: SensorSettings | None = None,
) -> Device:
    """The emulated device of an experiment, as behind `loopback:` and `emulated:`.

    Args:
        experiment: The experiment.
        settings: Command of its motors, what it measures, its watchdog.
        key: The pre-shared key; None for unsigned frames.
        motor_lag: Time constant of the motors, in [s]; that of the settings when None.
        sensors: Errors of the sensors; those of the settings when None.

    Raises:
        InputError: A value is out of range.
    """
    emulator = settings.emulator
    robot = EmulatedRobot.of_experiment(
        experiment,
        motor_lag=emulator.motor_lag if motor_lag is None else motor_lag,
        sensors=emulator.sensors if sensors is None else sensors,
    )
    return device_of(robot, settings, key)


def device_of(robot: EmulatedRobot, settings: HardwareSettings, key: bytes | None = None) -> Device:
    """The device of an emulated robot.

    Args:
        robot: The robot.
        settings: Command of its motors, what it measures, its watchdog.
        key: The pre-shared key; None for unsigned frames.

    Raises:
        InputError: A value is out of range.
    """
    return Device(
        robot,
        hardware_signature(robot.plant.robot, settings),
        robot.plant.step_size,
        scale=settings.scale,
        key=key,
        watchdog=settings.watchdog,
        f_min=robot.drive.lower,
        f_max=robot.drive.upper,
    )
