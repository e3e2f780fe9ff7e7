"""Device of an emulated robot."""

from __future__ import annotations

from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.settings.hardware import HardwareSettings
from cardsflow_fmu.hardware.device.device import Device
from cardsflow_fmu.hardware.protocol.signals import hardware_signature

from .emulator import EmulatedRobot


def emulated_device(
    experiment: Experiment, settings: HardwareSettings, key: bytes | None = None
) -> Device:
    """Return the emulated device of an experiment, for the links `loopback:` and `emulated:`.

    Args:
        settings: Hardware settings of the experiment, with the address of the link.
        key: Pre-shared key, or None for unsigned frames.
    """
    robot = EmulatedRobot.from_experiment(experiment, settings.emulator)
    return device_of(robot, settings, key)


def device_of(robot: EmulatedRobot, settings: HardwareSettings, key: bytes | None = None) -> Device:
    """Return the device of an emulated robot.

    Args:
        settings: Hardware settings, which specify signals, scale and watchdog.
        key: Pre-shared key, or None for unsigned frames.

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
        f_min=robot.bounds[0],
        f_max=robot.bounds[1],
    )
