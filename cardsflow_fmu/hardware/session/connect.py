"""Sessions with the hardware of an experiment, and environment variables for FMUs."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.settings.hardware import HardwareSettings
from cardsflow_fmu.hardware.emulator.emulated_device import emulated_device
from cardsflow_fmu.hardware.links.link import HardwareLink
from cardsflow_fmu.hardware.links.ros_link import RosLink
from cardsflow_fmu.hardware.protocol.device_topics import DeviceTopics
from cardsflow_fmu.hardware.protocol.handshake import Handshake
from cardsflow_fmu.hardware.protocol.recording import Recorder, RecordingHeader
from cardsflow_fmu.hardware.protocol.signals import (
    hardware_signals,
    hardware_signature,
    require_forces,
)
from cardsflow_fmu.utils.key_file import read_key
from sim_dart.estimation.fitted_pose import FittedPose
from sim_dart.muscles.paths import MusclePaths

from .open_link import ADDRESSES, open_link
from .session import HardwareSession

LINK = "CARDSFLOW_HARDWARE_LINK"
KEY_FILE = "CARDSFLOW_HARDWARE_KEY_FILE"
RECORDING = "CARDSFLOW_HARDWARE_RECORDING"


@dataclass(frozen=True, slots=True)
class Connection:
    """Address, key file and recording of a run with hardware.

    Attributes:
        link: Address of the hardware. If empty, the address of the experiment is used.
        key_file: File of the pre-shared key. If None, the key file of the experiment is used.
        recording: File for recording all exchanges, or None for no recording.
    """

    link: str = ""
    key_file: Path | None = None
    recording: Path | None = None

    @classmethod
    def from_environment(cls) -> Connection:
        """Return the connection that the environment variables specify."""
        link, *files = (os.environ.get(name, "") for name in (LINK, KEY_FILE, RECORDING))
        key_file, recording = (Path(file) if file else None for file in files)
        return cls(link, key_file, recording)

    @contextmanager
    def exported(self) -> Iterator[None]:
        """Set the environment variables for FMUs that start within the context."""
        files = {KEY_FILE: self.key_file, RECORDING: self.recording}
        variables = {name: str(file.resolve()) for name, file in files.items() if file is not None}
        variables |= {LINK: self.link} if self.link else {}
        before = {name: os.environ.get(name) for name in variables}
        os.environ.update(variables)
        try:
            yield
        finally:
            for name, value in before.items():
                os.environ.pop(name)
                if value is not None:
                    os.environ[name] = value


def with_link(settings: HardwareSettings, file: Path, link: str) -> HardwareSettings:
    """Return the hardware settings with the effective address of the hardware.

    Args:
        file: File of the settings, used in messages.
        link: The address. If empty, the address of the settings or of the environment is used.
    """
    link = link or settings.link or os.environ.get(LINK, "")
    if not link:
        problem = f"missing; specify the address of the hardware ({ADDRESSES}), or set {LINK}"
        raise InputError(problem, file=file, key="hardware.link")
    return settings.copy_with(link=link)


def make_session(experiment: Experiment, connection: Connection | None = None) -> HardwareSession:
    """Create a session with the hardware of an experiment. Its method `open` connects it.

    Args:
        connection: Values that replace settings of the experiment. If None, the environment
            variables specify them.

    Raises:
        InputError: No address is specified, or the key cannot be read.
    """
    connection = connection or Connection.from_environment()
    settings = with_link(experiment.hardware, experiment.file, connection.link)
    robot = experiment.robot
    require_forces(robot, experiment.file)
    handshake = handshake_of(robot, settings, experiment.run.step)
    key_file = settings.key_file or connection.key_file or os.environ.get(KEY_FILE)
    key = read_key(key_file) if key_file else None
    link = open_link(
        settings.link,
        key=key,
        bind=settings.bind,
        make_device=lambda: emulated_device(experiment, settings, key),
        faults=settings.emulator,
        make_topics=lambda address: DeviceTopics(robot, settings, address),
    )
    if isinstance(link, RosLink):  # the timeout limits the missed states, not their number
        max_missed = math.ceil(link.silence / handshake.step)
        settings = settings.copy_with(max_missed=max(max_missed, settings.max_missed))
    file = connection.recording
    make_recorder = (lambda: Recorder(file, _header(robot, settings, link))) if file else None
    pose = None if settings.has_positions else _fitted_pose(experiment)
    return HardwareSession(robot, settings, link, handshake, make_recorder, link.clock, pose)


def require_connectable(experiment: Experiment) -> None:
    """Check the settings for the connection to the hardware without connecting.

    An external hardware.fmu without an address is accepted, since it may contain the address.

    Raises:
        InputError: The address is missing or invalid, the key cannot be read, or a bound is
            missing.
    """
    is_external = "hardware" in experiment.fmus and not experiment.hardware.link
    if experiment.hardware.use and not is_external:
        make_session(experiment, Connection())


def _fitted_pose(experiment: Experiment) -> FittedPose:
    """Return the pose fit for hardware without joint positions, beginning at the start pose.

    The estimator settings specify the length offsets. Lengths with drifting offsets are ignored if
    the others determine the pose.
    """
    estimator, q = experiment.estimator, np.array(experiment.start.q)
    if estimator is None:
        problem = "without measured joint positions the experiment requires an [estimator]"
        raise InputError(problem, file=experiment.file, key="hardware.has_positions")
    drifts = np.array(estimator.offset_drift) > 0.0
    others = MusclePaths(experiment.robot).evaluate(q).jacobian[~drifts]
    is_known = np.linalg.matrix_rank(others) == len(q)
    slack = np.where(drifts & is_known, np.inf, estimator.min_tension)
    return FittedPose(experiment.robot, q, np.array(estimator.offset), slack)


def handshake_of(robot: Robot, settings: HardwareSettings, step: float) -> Handshake:
    """Return the handshake for a robot."""
    n, m, motors = len(robot.coordinates), len(robot.muscles), len(robot.motors)
    return Handshake(
        signature=hardware_signature(robot, settings),
        step=step,
        scale=settings.scale,
        watchdog=settings.watchdog,
        commands=m + motors,
        states=settings.states(n, m, motors),
        lockstep=not settings.is_paced,
    )


def measured_positions(experiment: Experiment) -> tuple[float, ...]:
    """Return the positions q that the hardware of an experiment measures, in [rad] or [m]."""
    session = make_session(experiment, Connection())
    try:
        session.open()
        return tuple(session.q.tolist())
    finally:
        session.end()


def _header(robot: Robot, settings: HardwareSettings, link: HardwareLink) -> RecordingHeader:
    """Return the header of a recording for the run that the link has started."""
    assert link.agreed is not None
    commands, states = hardware_signals(robot, settings)
    return RecordingHeader(
        command_names=tuple(name for name, _ in commands),
        command_units=tuple(unit for _, unit in commands),
        state_names=tuple(name for name, _ in states),
        state_units=tuple(unit for _, unit in states),
        signature=link.agreed.signature,
        step=link.agreed.step,
        scale=link.agreed.scale,
        lockstep=link.agreed.lockstep,
        run_id=link.run_id,
        link=settings.link,
        start_state=tuple(link.start_state.tolist()),
    )
