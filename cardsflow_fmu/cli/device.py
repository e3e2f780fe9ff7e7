"""`cardsflow device` and `replay-hardware`: devices without hardware."""

from __future__ import annotations

import argparse
import contextlib
import math
import os
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.json_text import json_text

from .common import FAILED, GOOD, Commands, add_settings, settings_of

if TYPE_CHECKING:
    from cardsflow_fmu.experiment.settings.hardware import (
        EmulatorSettings,
        Faults,
        HardwareSettings,
    )
    from cardsflow_fmu.hardware.device.device import Device
    from cardsflow_fmu.hardware.device.server import DeviceServer
    from cardsflow_fmu.hardware.emulator.emulator import EmulatedRobot
    from cardsflow_fmu.ros.device_node import DeviceNode
    from cardsflow_fmu.ros.scene_topics import Shown
    from cardsflow_fmu.ros_interface.address import NodeAddress

DEFAULT_ADDRESS = "udp://127.0.0.1:5005"

_AS_GIVEN = ("noise", "differentiate_positions", "loss", "duplicate", "reorder", "corrupt", "seed")
_MILLISECONDS = ("motor_lag", "delay", "jitter")
"""Options that are settings of an emulator."""


def add_device(commands: Commands) -> None:
    """Add `device`."""
    parser = commands.add(
        "device",
        _device,
        "Emulate hardware: a simulated robot behind the hardware protocol, until Ctrl-C.",
        "cardsflow device examples/planar_2r --listen udp://127.0.0.1:5005 --loss 0.01",
    )
    parser.add_argument("thing", metavar="ROBOT|EXPERIMENT", type=Path, help="what to simulate")
    add_settings(parser, "setting of the experiment", "plant.mass_scale=1.2")
    parser.add_argument("--cable-set", help="the robot's cable set; the file's own when left out")
    parser.add_argument(
        "--step", type=float, metavar="S", help="internal step of a robot, in s; 0.001"
    )
    beside = parser.add_argument_group("ROS 2, beside the hardware protocol")
    group = beside.add_mutually_exclusive_group()
    group.add_argument(
        "--publish",
        metavar="URI",
        help="publish what the device measures: ros2://NAMESPACE?domain=N&node=NAME",
    )
    group.add_argument(
        "--ros2",
        metavar="URI",
        help="publish it, and take commands from the topic device_commands, or with "
        "controller=NAME from NAME/commands as a forward_command_controller does, while no other "
        "run is under way; without a command for the timeout forces are ramped down: "
        "ros2://?timeout=0.1",
    )
    _add_imperfections(parser)
    _add_serving(parser)


def add_replay(commands: Commands) -> None:
    """Add `replay-hardware`."""
    parser = commands.add(
        "replay-hardware",
        _replay,
        "Be the device of a recorded run, until Ctrl-C: the same states, whatever is commanded.",
        "cardsflow replay-hardware results/hardware.rec --listen udp://127.0.0.1:5005",
    )
    parser.add_argument("recording", type=Path, help="the hardware.rec of a run")
    _add_serving(parser)


def _add_imperfections(parser: argparse.ArgumentParser) -> None:
    said = "motors and sensors; where silent, as [hardware.emulator] of the experiment says"
    group = parser.add_argument_group(said)
    group.add_argument(
        "--encoder",
        type=float,
        metavar="COUNTS",
        help="counts of the encoders per rad or m; velocities are then differences of counts",
    )
    group.add_argument(
        "--noise", type=float, metavar="X", help="of positions, in rad or m (1 sigma)"
    )
    group.add_argument(
        "--differences",
        dest="differentiate_positions",
        action="store_true",
        default=None,
        help="velocities are differences of positions",
    )
    group.add_argument("--motor-lag", type=float, metavar="MS", help="motors' time constant")


def _add_serving(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--listen",
        default=DEFAULT_ADDRESS,
        metavar="udp://HOST:PORT",
        help=f"where to listen; port 0 takes a free one; {DEFAULT_ADDRESS}",
    )
    parser.add_argument(
        "--watchdog",
        type=float,
        metavar="MS",
        help="without a command for so long the device goes to its safe state; that of the "
        "experiment, or 20",
    )
    parser.add_argument(
        "--key-file",
        type=Path,
        help="the key that frames must be signed with; that of the experiment, or of the "
        "environment variable CARDSFLOW_HARDWARE_KEY_FILE, when left out",
    )
    parser.add_argument("--duration", type=float, metavar="S", help="end after so many seconds")
    parser.add_argument("--json", action="store_true", help="print every line as JSON")
    _add_faults(parser)


def _add_faults(parser: argparse.ArgumentParser) -> None:
    said = "faults of the link, in each direction; where silent, as the experiment says"
    group = parser.add_argument_group(said)
    for name, what in (
        ("loss", "are lost"),
        ("duplicate", "come twice"),
        ("reorder", "are overtaken by the next"),
        ("corrupt", "are damaged"),
    ):
        text = f"part of the frames that {what}, 0 to 1"
        group.add_argument(f"--{name}", type=float, metavar="P", help=text)
    group.add_argument("--delay", type=float, metavar="MS", help="delay of frames")
    group.add_argument("--jitter", type=float, metavar="MS", help="largest additional delay")
    group.add_argument(
        "--outage",
        action="append",
        default=[],
        metavar="START:LENGTH",
        help="no frame gets through, in s from the first frame on; may be repeated",
    )
    group.add_argument("--seed", type=int, metavar="N", help="of noise and faults; 0")


def _device(options: argparse.Namespace) -> int:
    from cardsflow_fmu.hardware.emulator.emulated_device import device_of

    address = _node_address(options)
    robot, settings, shown = _emulated(options)
    if options.watchdog is not None:
        settings = settings.replaced(watchdog=options.watchdog * 1e-3)
    key = _key(options, settings.key_file)
    device = device_of(robot, settings, key)

    def beside(server: DeviceServer, report: Callable[[str], object]) -> DeviceNode | None:
        if address is None:
            return None
        from cardsflow_fmu.ros.device_node import DeviceNode

        takes_commands = options.ros2 is not None
        node = DeviceNode(
            device, shown, settings, server.own_uri, address, key, report, takes_commands
        )
        if takes_commands:
            what = "topics have no key: whoever reaches them can command the robot"
            print(f"cardsflow: warning: {options.ros2} {what}", file=sys.stderr)
        report(node.description)
        return node

    _serve(device, options, settings.emulator, beside=beside)
    return FAILED if device.counters["faults"] else GOOD


def _node_address(options: argparse.Namespace) -> NodeAddress | None:
    """The address of the node of ROS beside a device; None where none is asked for.

    Raises:
        InputError: It is none, or commands are to be taken and no timeout is stated.
    """
    from cardsflow_fmu.ros_interface.address import node_address

    if options.ros2 is None:
        return None if options.publish is None else node_address(options.publish)
    address = node_address(options.ros2)
    if address.timeout is None:
        what = "commands by a topic need a stated timeout, such as ros2://?timeout=0.1"
        raise InputError(what, key="--ros2")
    return address


def _emulated(
    options: argparse.Namespace,
) -> tuple[EmulatedRobot, HardwareSettings, Shown]:
    """The robot of an experiment or of a robot's files, and the settings of its hardware."""
    from cardsflow_fmu.experiment.experiment import Experiment
    from cardsflow_fmu.experiment.settings.hardware import HardwareSettings
    from cardsflow_fmu.hardware.emulator.emulator import EmulatedRobot
    from cardsflow_fmu.ros.scene_topics import Shown

    thing = options.thing
    if (thing / "experiment.toml").is_file() or thing.suffix in (".toml", ".json"):
        for option, key in (("cable_set", "robot.cable_set"), ("step", "plant.step")):
            if getattr(options, option) is not None:
                what = f"of an experiment is changed by --set {key}=..."
                raise InputError(what, key=f"--{option.replace('_', '-')}")
        experiment = Experiment.load(thing, settings_of(options.set))
        settings = _with_imperfections(options, experiment.hardware)
        own = settings.emulator
        emulated = EmulatedRobot.of_experiment(
            experiment, motor_lag=own.motor_lag, sensors=own.sensors
        )
        return emulated, settings, Shown.of(experiment)
    from addin_sdfusion.robot.formats.read import read
    from cardsflow_fmu.experiment.carried_files import mesh_roots

    if options.set:
        raise InputError("changes an experiment, and this is a robot", key="--set")
    settings = _with_imperfections(options, HardwareSettings())
    own = settings.emulator
    robot = read(thing, options.cable_set).require()
    step = 1e-3 if options.step is None else options.step
    emulated = EmulatedRobot(robot, step, motor_lag=own.motor_lag, sensors=own.sensors)
    return emulated, settings, Shown(robot, thing.parent, mesh_roots(thing, [thing], ()))


def _with_imperfections(options: argparse.Namespace, own: HardwareSettings) -> HardwareSettings:
    """The settings with those imperfections of robot and line that options name."""
    return own.replaced(emulator=_imperfections(options, own.emulator))


def _imperfections(options: argparse.Namespace, own: EmulatorSettings) -> EmulatorSettings:
    words = {key: value for key, value in vars(options).items() if value is not None}
    given: dict[str, Any] = {key: words[key] for key in _AS_GIVEN if key in words}
    given |= {key: words[key] * 1e-3 for key in _MILLISECONDS if key in words}
    if options.outage:
        given["outages"] = tuple(map(_outage, options.outage))
    counts = words.get("encoder")
    if counts is not None:
        if not counts > 0:
            raise InputError(f"must be above 0 counts, not {counts!r}", key="--encoder")
        given |= {"joint_counts": counts, "length_counts": counts, "differentiate_positions": True}
    return type(own)(**{**own.data(), **given})


def _replay(options: argparse.Namespace) -> int:
    from cardsflow_fmu.experiment.settings.hardware import EmulatorSettings
    from cardsflow_fmu.hardware.device.device import Device
    from cardsflow_fmu.hardware.emulator.replay import ReplayedRobot
    from cardsflow_fmu.hardware.protocol.recording import read_recording

    recording = read_recording(options.recording)
    if recording.lost_bytes:
        what = f"the last {recording.lost_bytes} bytes are no whole record, and are left out"
        print(f"cardsflow: warning: {options.recording}: {what}", file=sys.stderr)
    header, robot = recording.header, ReplayedRobot(recording)
    device = Device(
        robot,
        header.signature,
        header.step,
        scale=header.scale,
        key=_key(options, None),
        watchdog=20e-3 if options.watchdog is None else options.watchdog * 1e-3,
        f_min=-math.inf,
        f_max=math.inf,
    )
    faults = _imperfections(options, EmulatorSettings())
    _serve(device, options, faults, lambda: {"largest change of a command": robot.deviation})
    return GOOD


def _key(options: argparse.Namespace, own: Path | None) -> bytes | None:
    from cardsflow_fmu.hardware.session.connect import KEY_FILE
    from cardsflow_fmu.utils.key_file import key_warning, read_key

    given = options.key_file or own or os.environ.get(KEY_FILE)
    if not given:
        return None
    warning = key_warning(Path(given), str(given))
    if warning is not None:
        print(f"cardsflow: warning: {warning}", file=sys.stderr)
    return read_key(given)


def _serve(
    device: Device,
    options: argparse.Namespace,
    faults: Faults,
    report: Callable[[], dict[str, Any]] = dict,
    beside: Callable[[DeviceServer, Callable[[str], object]], DeviceNode | None] = lambda *_: None,
) -> None:
    """Serve a device until Ctrl-C, SIGTERM or the end of its duration; print its events."""
    from cardsflow_fmu.cosim.pacing import real_time_priority
    from cardsflow_fmu.hardware.device.server import DeviceServer
    from cardsflow_fmu.hardware.device.status import Event, StatusReporter
    from cardsflow_fmu.hardware.emulator.faults import FaultyLine
    from cardsflow_fmu.utils.interrupts import interruptible

    line = FaultyLine(device, faults) if faults.any else None
    duration = _duration(options)

    def say(text: str, **data: Any) -> None:
        print(json_text(data) if options.json else text, flush=True)

    def report_event(event: Event) -> None:
        say(str(event), **asdict(event))

    with interruptible() as pressed, DeviceServer(device, options.listen, line=line) as server:
        status = StatusReporter(device, report_event)
        if server.is_open and not device.is_signed:
            what = "has no key: whoever reaches it can command the robot; give it a --key-file"
            print(f"cardsflow: warning: {server.uri} {what}", file=sys.stderr)
        say(f"listening on {server.uri}", listening=server.uri)
        node = beside(server, lambda line: say(line, ros2=line))
        end = time.monotonic() + duration

        def stop() -> bool:
            status.update()
            if node is not None:
                node.take_state()
            return bool(pressed) or time.monotonic() >= end

        with node or contextlib.nullcontext(), real_time_priority():
            server.run(stop)
        status.update()
        totals = {"device": dict(device.counters), "slipped": server.slipped, **report()}
        totals |= {} if line is None else {"faults": line.counters}
        totals |= {} if node is None else node.totals
        say("\n".join(_lines(totals)), **totals)


def _lines(totals: Mapping[str, Any], prefix: str = "") -> list[str]:
    """Totals for people, a line a group."""
    groups = {name: value for name, value in totals.items() if isinstance(value, Mapping)}
    numbers = {name: value for name, value in totals.items() if name not in groups}
    shown = ", ".join(
        f"{name} {value:.6g}" if isinstance(value, float) else f"{name} {value}"
        for name, value in numbers.items()
    )
    lines = [f"{prefix or 'totals'}: {shown}"] if shown else []
    for name, group in groups.items():
        lines += _lines(group, f"{prefix} {name}".strip())
    return lines


def _outage(text: str) -> tuple[float, float]:
    begin, _, length = text.partition(":")
    try:
        return float(begin), float(length)
    except ValueError:
        what = f"must be START:LENGTH in s, such as 2:0.2, not {text!r}"
        raise InputError(what, key="--outage") from None


def _duration(options: argparse.Namespace) -> float:
    if options.duration is None:
        return math.inf
    if not options.duration > 0:
        raise InputError(f"must be above 0 s, not {options.duration!r}", key="--duration")
    return float(options.duration)
