"""`cardsflow device` and `replay-hardware`: emulated devices."""

from __future__ import annotations

import argparse
import contextlib
import math
import os
import re
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.json_text import json_text

from .common import FAILED, GOOD, add_cable_set, add_json, add_settings, parse_settings
from .parser import Commands
from .terminal.messages import print_warning

if TYPE_CHECKING:
    from addin_sdfusion.robot import Robot
    from cardsflow_fmu.experiment.settings.hardware import (
        Faults,
        HardwareSettings,
    )
    from cardsflow_fmu.hardware.device.device import Device
    from cardsflow_fmu.hardware.device.server import DeviceServer
    from cardsflow_fmu.hardware.emulator.emulator import EmulatedRobot
    from cardsflow_fmu.ros.device_node import DeviceNode
    from cardsflow_fmu.ros.scene_topics import ShownRobot
    from cardsflow_fmu.ros_interface.address import NodeAddress

DEFAULT_ADDRESS = "udp://127.0.0.1:5005"


def add_device(commands: Commands) -> None:
    """Add `device`."""
    parser = commands.add(
        "device",
        _device,
        "Emulate hardware: serve a simulated robot by the hardware protocol.",
        "cardsflow device examples/planar_2r --set hardware.emulator.loss=0.01",
        "It runs until Ctrl-C.",
    )
    text = "the robot or the experiment to simulate"
    parser.add_argument("path", metavar="ROBOT|EXPERIMENT", type=Path, help=text)
    text = "setting of an experiment, or of [hardware] for a robot"
    add_settings(parser, text, "hardware.emulator.loss=0.01")
    add_cable_set(parser, "robot")
    parser.add_argument(
        "--step", type=float, metavar="S", help="time step of a robot, in s (default: 0.001)"
    )
    ros = parser.add_argument_group("ROS 2, in addition to the hardware protocol")
    group = ros.add_mutually_exclusive_group()
    text = "publish the measurements: ros2://NAMESPACE?domain=N&node=NAME (default: none)"
    group.add_argument("--publish", metavar="URI", help=text)
    group.add_argument(
        "--ros2",
        metavar="URI",
        help="publish the measurements, and accept commands from the topic device_commands, or "
        "with controller=NAME from NAME/commands like a forward_command_controller, while no "
        "other run is active; after the timeout without a command the forces are ramped down: "
        "ros2://?timeout=0.1 (default: none)",
    )
    parser.add_argument(
        "--fault",
        action="append",
        default=[],
        metavar="KIND:NAME[=VALUE]@TIME",
        help="failure of a cable, motor or sensor, such as broken:motor3@2.0 or "
        "length_bias:motor3=0.01@2.0; repeatable (default: failures of [hardware.emulator] in the "
        "experiment)",
    )
    _add_serving(parser)


def add_replay(commands: Commands) -> None:
    """Add `replay-hardware`."""
    parser = commands.add(
        "replay-hardware",
        _replay,
        "Replay a hardware recording as a device.",
        "cardsflow replay-hardware results/hardware.rec --listen udp://127.0.0.1:5005",
        "The device sends the recorded states and ignores the commands. It runs until Ctrl-C.",
    )
    parser.add_argument("recording", type=Path, help="the hardware.rec of a run")
    add_settings(parser, "setting of [hardware]", "hardware.emulator.loss=0.01")
    _add_serving(parser)


def _add_serving(parser: argparse.ArgumentParser) -> None:
    text = f"address to listen on; port 0 selects a free port (default: {DEFAULT_ADDRESS})"
    parser.add_argument("--listen", default=DEFAULT_ADDRESS, metavar="udp://HOST:PORT", help=text)
    parser.add_argument(
        "--watchdog",
        type=float,
        metavar="MS",
        help="time without a command after which the device enters its safe state, in ms "
        "(default: hardware.watchdog of the experiment, or 20)",
    )
    parser.add_argument(
        "--key-file",
        type=Path,
        metavar="FILE",
        help="file with the key for signed frames (default: hardware.key_file of the experiment, "
        "or the environment variable CARDSFLOW_HARDWARE_KEY_FILE)",
    )
    parser.add_argument(
        "--duration", type=float, metavar="S", help="stop after this time, in s (default: never)"
    )
    add_json(parser, "every line")


def _device(options: argparse.Namespace) -> int:
    from cardsflow_fmu.hardware.emulator.emulated_device import device_of

    address = _node_address(options)
    robot, settings, shown = _emulated_robot(options)
    if options.watchdog is not None:
        settings = settings.copy_with(watchdog=options.watchdog * 1e-3)
    key = _key(options, settings.key_file)
    device = device_of(robot, settings, key)

    def create_node(server: DeviceServer, report: Callable[[str], object]) -> DeviceNode | None:
        if address is None:
            return None
        from cardsflow_fmu.ros.device_node import DeviceNode

        accepts_commands = options.ros2 is not None
        node = DeviceNode(
            device, shown, settings, server.own_uri, address, key, report, accepts_commands
        )
        if accepts_commands:
            print_warning(
                f"{options.ros2}: topics are not signed: anyone on the network can send commands"
            )
        report(node.description)
        return node

    _serve(device, options, settings.emulator, create_node=create_node)
    return FAILED if device.counters["faults"] else GOOD


def _node_address(options: argparse.Namespace) -> NodeAddress | None:
    """Return the address of the ROS node of a device, or None if no node is requested.

    Raises:
        InputError: The address is invalid, or it accepts commands and has no timeout.
    """
    from cardsflow_fmu.ros_interface.address import node_address

    if options.ros2 is None:
        return None if options.publish is None else node_address(options.publish)
    address = node_address(options.ros2)
    if address.timeout is None:
        problem = "commands from a topic need a timeout, such as ros2://?timeout=0.1"
        raise InputError(problem, key="--ros2")
    return address


def _emulated_robot(
    options: argparse.Namespace,
) -> tuple[EmulatedRobot, HardwareSettings, ShownRobot]:
    """Return the robot of an experiment or of robot files, with its hardware settings."""
    from cardsflow_fmu.experiment.experiment import Experiment
    from cardsflow_fmu.hardware.emulator.emulator import EmulatedRobot
    from cardsflow_fmu.ros.scene_topics import ShownRobot

    path = options.path
    if (path / "experiment.toml").is_file() or path.suffix in (".toml", ".json"):
        for option, key in (("cable_set", "robot.cable_set"), ("step", "plant.step")):
            if getattr(options, option) is not None:
                problem = f"is only for robots; for an experiment use --set {key}=..."
                raise InputError(problem, key=f"--{option.replace('_', '-')}")
        experiment = Experiment.load(path, parse_settings(options.set))
        settings = _with_failures(experiment.hardware, options.fault)
        emulated = EmulatedRobot.from_experiment(experiment, settings.emulator)
        return emulated, settings, ShownRobot.from_experiment(experiment)
    from addin_sdfusion.robot.formats.read import read
    from cardsflow_fmu.experiment.packed_files import mesh_roots

    robot = read(path, options.cable_set).require()
    step = 1e-3 if options.step is None else options.step
    settings = _hardware_settings(options, path, step, robot)
    settings = _with_failures(settings, options.fault)
    emulated = EmulatedRobot(robot, step, emulator=settings.emulator)
    return emulated, settings, ShownRobot(robot, path.parent, mesh_roots(path, [path], ()))


def _hardware_settings(
    options: argparse.Namespace, file: Path, step: float, robot: Robot | None = None
) -> HardwareSettings:
    """Return the settings of [hardware] that `--set` specifies.

    Raises:
        InputError: A setting is invalid, or not in [hardware].
    """
    from cardsflow_fmu.experiment.config.key_path import set_value
    from cardsflow_fmu.experiment.config.table import Context
    from cardsflow_fmu.experiment.settings.hardware import read_hardware
    from cardsflow_fmu.experiment.settings.robots import robot_names

    data: dict[str, Any] = {}
    for key, value in parse_settings(options.set).items():
        set_value(data, key, value, file)
    if data.keys() - {"hardware"}:
        raise InputError("only settings of [hardware] apply without an experiment", key="--set")
    names = None if robot is None else robot_names(robot)
    return read_hardware(data.get("hardware", {}), Context(file, names), step)


def _with_failures(settings: HardwareSettings, words: Sequence[str]) -> HardwareSettings:
    if not words:
        return settings
    table = settings.emulator
    data = {**table.data(), "failures": tuple(map(_failure, words))}
    return settings.copy_with(emulator=type(table)(**data))


def _replay(options: argparse.Namespace) -> int:
    from cardsflow_fmu.hardware.device.device import Device
    from cardsflow_fmu.hardware.emulator.replay import ReplayedRobot
    from cardsflow_fmu.hardware.protocol.recording import read_recording

    recording = read_recording(options.recording)
    if recording.lost_bytes:
        problem = f"the last {recording.lost_bytes} bytes are an incomplete record and are ignored"
        print_warning(f"{options.recording}: {problem}")
    header, robot = recording.header, ReplayedRobot(recording)
    settings = _hardware_settings(options, options.recording, header.step)
    device = Device(
        robot,
        header.signature,
        header.step,
        scale=header.scale,
        key=_key(options, settings.key_file),
        watchdog=settings.watchdog if options.watchdog is None else options.watchdog * 1e-3,
        f_min=-math.inf,
        f_max=math.inf,
    )
    _serve(
        device,
        options,
        settings.emulator,
        lambda: {"largest difference of a command": robot.deviation},
    )
    return GOOD


def _key(options: argparse.Namespace, key_file: Path | None) -> bytes | None:
    from cardsflow_fmu.hardware.session.connect import KEY_FILE
    from cardsflow_fmu.utils.key_file import key_warning, read_key

    key_path = options.key_file or key_file or os.environ.get(KEY_FILE)
    if not key_path:
        return None
    warning = key_warning(Path(key_path), str(key_path))
    if warning is not None:
        print_warning(warning)
    return read_key(key_path)


def _serve(
    device: Device,
    options: argparse.Namespace,
    faults: Faults,
    report: Callable[[], dict[str, Any]] = dict,
    create_node: Callable[[DeviceServer, Callable[[str], object]], DeviceNode | None] = lambda *_: (
        None
    ),
) -> None:
    """Serve a device until Ctrl-C, SIGTERM or the end of its duration; print its events."""
    from cardsflow_fmu.cosim.pacing import real_time_priority
    from cardsflow_fmu.hardware.device.server import DeviceServer
    from cardsflow_fmu.hardware.device.status import Event, StatusReporter
    from cardsflow_fmu.hardware.emulator.faults import FaultyLine
    from cardsflow_fmu.utils.interrupts import collect_interrupts

    line = FaultyLine(device, faults) if faults.any else None
    duration = _duration(options)

    def print_line(text: str, **data: Any) -> None:
        print(json_text(data) if options.json else text, flush=True)

    def report_event(event: Event) -> None:
        print_line(str(event), **asdict(event))

    with collect_interrupts() as pressed, DeviceServer(device, options.listen, line=line) as server:
        status = StatusReporter(device, report_event, lambda: server.lateness)
        if server.is_open and not device.is_signed:
            problem = "frames are not signed: anyone on the network can send commands; use"
            print_warning(f"{server.uri}: {problem} --key-file")
        print_line(f"listening on {server.uri}", listening=server.uri)
        node = create_node(server, lambda line: print_line(line, ros2=line))
        end = time.monotonic() + duration

        def stop() -> bool:
            status.update()
            if node is not None:
                node.sample_state()
            return bool(pressed) or time.monotonic() >= end

        with node or contextlib.nullcontext(), real_time_priority():
            server.run(stop)
        status.update()
        totals = {"device": dict(device.counters), "slipped": server.slipped, **report()}
        totals |= {} if line is None else {"faults": line.counters}
        totals |= {} if node is None else node.totals
        print_line("\n".join(_lines(totals)), **totals)


def _lines(totals: Mapping[str, Any], prefix: str = "") -> list[str]:
    """Return the totals as text, one line per group."""
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


def _failure(text: str) -> dict[str, Any]:
    """Return a failure as plain data, from KIND:NAME[=VALUE]@TIME."""
    match = re.fullmatch(r"([^:]+):([^=@]+)(?:=([^@]+))?@([^@]+)", text)
    if match is None:
        problem = f"must be KIND:NAME[=VALUE]@TIME, such as broken:motor3@2.0, not {text!r}"
        raise InputError(problem, key="--fault")
    kind, part, value, time_ = match.groups()
    data: dict[str, Any] = {"kind": kind, "part": part}
    try:
        data["time"] = float(time_)
        if value is not None:
            data |= {"other": value} if kind == "length_swapped" else {"value": float(value)}
    except ValueError:
        raise InputError(f"must have numbers in {text!r}", key="--fault") from None
    return data


def _duration(options: argparse.Namespace) -> float:
    if options.duration is None:
        return math.inf
    if not options.duration > 0:
        raise InputError(f"must be positive, not {options.duration!r}", key="--duration")
    return float(options.duration)
