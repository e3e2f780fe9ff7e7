"""From an experiment to a session with its hardware, and what the environment says about it."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from addin_sdfusion.robot import InputError, Robot
from cardsflow_fmu.experiment.hardware_settings import HardwareSettings
from cardsflow_fmu.hardware.emulator.emulated_device import emulated_device
from cardsflow_fmu.hardware.links.link import HardwareLink
from cardsflow_fmu.hardware.protocol.handshake import Hello
from cardsflow_fmu.hardware.protocol.recording import Recorder, RecordingHeader
from cardsflow_fmu.hardware.protocol.signals import (
    hardware_signals,
    hardware_signature,
    require_forces,
)
from cardsflow_fmu.utils.key_file import read_key

from .open_link import ADDRESSES, open_link
from .session import HardwareSession

if TYPE_CHECKING:
    from cardsflow_fmu.experiment.experiment import Experiment

LINK = "CARDSFLOW_HARDWARE_LINK"
KEY_FILE = "CARDSFLOW_HARDWARE_KEY_FILE"
RECORDING = "CARDSFLOW_HARDWARE_RECORDING"


@contextmanager
def environment(settings: HardwareSettings, recording: Path | None = None) -> Iterator[None]:
    """What an experiment says about the way to its hardware, for the FMUs started meanwhile.

    Args:
        settings: What it says; where it is silent, the environment stays as it is.
        recording: Where to write every exchange; nowhere when None.
    """
    given = {
        LINK: settings.link or None,
        KEY_FILE: None if settings.key_file is None else str(settings.key_file.resolve()),
        RECORDING: None if recording is None else str(recording.resolve()),
    }
    before = {name: os.environ.get(name) for name in given}
    _set({name: value for name, value in given.items() if value is not None})
    try:
        yield
    finally:
        _set(before)


def _set(values: Mapping[str, str | None]) -> None:
    for name, value in values.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value


def linked(settings: HardwareSettings, file: Path) -> HardwareSettings:
    """The settings with the link that is used, which the environment may override.

    Args:
        settings: What is said of the hardware.
        file: Where that is said.

    Raises:
        InputError: Nothing tells where the hardware is.
    """
    link = os.environ.get(LINK) or settings.link
    if not link:
        what = f"missing: say where the hardware is ({ADDRESSES}), or set {LINK}"
        raise InputError(what, file=file, key="hardware.link")
    return replace(settings, link=link)


def session_of(experiment: Experiment) -> HardwareSession:
    """A session with an experiment's hardware, not open yet.

    Args:
        experiment: The experiment; the environment overrides its link.

    Raises:
        InputError: Nothing tells where the hardware is, or its key cannot be read.
    """
    settings = linked(experiment.hardware, experiment.file)
    robot = experiment.robot
    require_forces(robot, experiment.file)
    n, m = len(robot.coordinates), len(robot.muscles)
    hello = Hello(
        signature=hardware_signature(robot, settings),
        step=experiment.run.step,
        scale=settings.scale,
        watchdog=settings.watchdog,
        commands=m,
        states=settings.states(n, m),
        lockstep=not settings.is_paced,
    )
    key = _key(settings)
    link = open_link(
        settings.link,
        key=key,
        bind=settings.bind,
        make_device=lambda: emulated_device(experiment, settings, key),
        faults=settings.emulator.faults,
    )
    file = os.environ.get(RECORDING)
    make_recorder = (lambda: Recorder(file, _header(robot, settings, link))) if file else None
    return HardwareSession(robot, settings, link, hello, make_recorder, link.clock)


def measured_start(experiment: Experiment) -> tuple[float, ...]:
    """Where the robot of an experiment's hardware is: q, in [rad] or [m].

    Args:
        experiment: The experiment.

    Raises:
        HardwareError: The hardware does not tell.
        InputError: Nothing tells where the hardware is.
    """
    session = session_of(experiment)
    try:
        session.open()
        return tuple(session.q.tolist())
    finally:
        session.end()


def _header(robot: Robot, settings: HardwareSettings, link: HardwareLink) -> RecordingHeader:
    """What a recording tells of its run, from what has been agreed on."""
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


def _key(settings: HardwareSettings) -> bytes | None:
    file = settings.key_file or os.environ.get(KEY_FILE)
    return read_key(file) if file else None
