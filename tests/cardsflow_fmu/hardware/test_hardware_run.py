"""Runs with hardware and in real time: settings, files, summaries, keys and exit codes."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
import tomllib
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.command_line import CommandLine
from support.experiments import resource_bytes, write_resources
from support.process_output import wait_until
from support.robots.robots import EXAMPLES, HELD, PLANAR_2R
from support.ssp_runs import simulate_system

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment
from cardsflow_fmu.experiment.settings.hardware import HardwareSettings
from cardsflow_fmu.hardware.device.server import DeviceServer
from cardsflow_fmu.hardware.emulator.emulated_device import emulated_device
from cardsflow_fmu.hardware.protocol.recording import read_recording
from cardsflow_fmu.hardware.session.approach import with_approach
from cardsflow_fmu.hardware.session.connect import KEY_FILE, LINK, RECORDING, Connection
from cardsflow_fmu.models.plant import PlantModel
from cardsflow_fmu.results.files import RECORDING_FILE
from cardsflow_fmu.results.report.summary_html import summary_tables
from cardsflow_fmu.runtime.library import this_platform
from cardsflow_fmu.simulation.build import build, build_fmus
from cardsflow_fmu.simulation.run import run, simulate
from cardsflow_fmu.utils.key_file import key_warning, read_key

SHORT = {"run.duration": 0.05}
LOCKSTEP = SHORT | {
    "hardware.link": "loopback:",
    "hardware.use": True,
    "hardware.mode": "lockstep",
    "hardware.ramp_in": 0.0,
}
REALTIME = SHORT | {
    "hardware.link": "loopback:",
    "hardware.use": True,
    "hardware.ramp_down": 0.01,
    "hardware.max_missed": 100_000,
    "hardware.watchdog": 10.0,  # test machines may be busy
}
ARM = EXAMPLES / "roboy_left_arm"


def load(settings: dict[str, Any], folder: Path = PLANAR_2R) -> Experiment:
    return Experiment.load(folder, settings)


def words(settings: dict[str, Any]) -> list[str]:
    return [
        word for key, value in settings.items() for word in ("--set", f"{key}={json.dumps(value)}")
    ]


@pytest.mark.slow
def test_hardware_settings_do_not_change_controller_and_plant_fmus(tmp_path: Path) -> None:
    """The FMUs are byte-identical in builds with and without [hardware], and in runs."""
    table = {
        "hardware.link": "udp://127.0.0.1:5005",
        "hardware.ramp_in": 0.3,
        "hardware.motors": {"command": "length", "stiffness": 3000.0},
    }
    here = [this_platform().tuple]  # FMUs of a run are not used by other runs
    without = build(load(SHORT), tmp_path / "a", platforms=here)
    with_table = build(load(SHORT | table), tmp_path / "b", platforms=here)
    run(load(LOCKSTEP), tmp_path / "c")
    run(load(LOCKSTEP | {"hardware.approach": 0.1}), tmp_path / "d")
    run(load(SHORT), tmp_path / "e")
    for name in ("controller", "plant", "reference"):
        assert with_table[name].read_bytes() == without[name].read_bytes()
    bare = build_fmus(load(SHORT | table), tmp_path, ["controller"], sources=False)["controller"]
    for folder in "cde":
        assert (tmp_path / folder / "controller.fmu").read_bytes() == bare.read_bytes()
    assert with_table["hardware"].read_bytes() != without["hardware"].read_bytes()


@pytest.mark.slow
def test_the_command_drives_hardware(tmp_path: Path, cardsflow: CommandLine) -> None:
    out = tmp_path / "out"
    settings = words(SHORT | {"hardware.mode": "lockstep", "hardware.ramp_in": 0.0})
    code, text, _ = cardsflow("run", PLANAR_2R, "--hardware", "loopback:", *settings, "-o", out)
    assert code == 0
    assert "hardware    loopback:, lockstep: 0 exchanges missed" in text
    names = {path.name for path in out.iterdir()}
    assert {"hardware.fmu", "hardware.rec", "controller.fmu", "summary.json"} < names
    assert "plant.fmu" not in names
    summary = json.loads((out / "summary.json").read_text())
    assert summary["status"] == "complete"
    assert summary["files"]["hardware.rec"] == "hardware.rec"
    assert cardsflow("run", PLANAR_2R, *words(SHORT), "-o", out)[0] == 0
    names = {path.name for path in out.iterdir()}
    assert "plant.fmu" in names
    assert not {"hardware.fmu", "hardware.rec"} & names


@pytest.mark.slow
def test_hardware_follows_predictive_control_as_the_simulation_does() -> None:
    """`controller.delay` is the delay of one tick that hardware adds."""
    settings = {"controller.type": "mpc", "controller.delay": 1, "run.step": 0.005}
    results = [
        simulate(load(settings | more, ARM)) for more in (SHORT, {**LOCKSTEP, "run.duration": 0.05})
    ]
    for result in results:
        assert not result["fallback"].any()
    errors = [
        max(abs(result[f"y.hand.{a}"] - result[f"y_d.hand.{a}"]).max() for a in "xyz")
        for result in results
    ]
    assert max(errors) < 1e-3, errors


@pytest.mark.slow
def test_every_exchange_is_recorded(tmp_path: Path) -> None:
    result = run(load(LOCKSTEP | {"hardware.ramp_down": 0.02}), tmp_path / "out")
    recording = read_recording(tmp_path / "out" / "hardware.rec")
    assert recording.header.command_names == tuple(f"f.cable_{k}" for k in (1, 2, 3, 4))
    assert len(recording) == 50 + 20  # includes the ramp down
    np.testing.assert_array_equal(recording.states[:50, 0], result["q.joint_1"][1:])
    np.testing.assert_array_equal(recording.commands[:50, 0], result["f.cable_1"][:50])
    assert result.files["hardware.rec"] == tmp_path / "out" / "hardware.rec"


@pytest.mark.slow
def test_the_recording_of_a_killed_run_is_overwritten(tmp_path: Path) -> None:
    out = tmp_path / "out"
    run(load(LOCKSTEP), out)
    for path in out.iterdir():
        if path.name != "hardware.rec":
            path.unlink()
    run(load(LOCKSTEP), out)
    (tmp_path / "mine").mkdir()
    mine = tmp_path / "mine" / "hardware.rec"
    mine.write_text("my own notes")
    with pytest.raises(InputError, match=r"hardware\.rec that no run has written"):
        run(load(LOCKSTEP), tmp_path / "mine")
    assert mine.read_text() == "my own notes"


@pytest.mark.slow
def test_a_limit_ends_the_run_with_partial_results(tmp_path: Path, cardsflow: CommandLine) -> None:
    out = tmp_path / "out"
    settings = words(LOCKSTEP | {"hardware.max_tension": 20.0})
    code, text, err = cardsflow("run", PLANAR_2R, *settings, "-o", out)
    assert code == 1
    assert "the tension of muscle 'cable_1' is 41.33 N, above its limit of 20 N" in err
    assert "Traceback" not in err
    assert "incomplete" in text
    summary = json.loads((out / "summary.json").read_text())
    assert summary["status"] == "incomplete"
    assert "above its limit" in summary["error"]
    assert (out / "hardware.rec").exists()


@pytest.mark.slow
def test_missing_devices_and_invalid_addresses_have_different_exit_codes(
    tmp_path: Path, cardsflow: CommandLine
) -> None:
    out = ["-o", str(tmp_path / "out")]
    silent = "udp://127.0.0.1:9"
    line = cardsflow.error_line("run", PLANAR_2R, "--hardware", silent, *out, code=1)
    assert f"no device answers at {silent}" in line
    assert not (tmp_path / "out").exists()
    unknown = ("smoke:signals", "5005", "UDP//127.0.0.1")
    for uri in (*unknown, "udp://", "udp://127.0.0.1:99999", "udp://127.0.0.1"):
        assert uri in cardsflow.error_line("run", PLANAR_2R, "--hardware", uri, *out)


@pytest.mark.slow
def test_a_paced_run_reports_its_timeliness() -> None:
    begin = time.monotonic()
    settings = SHORT | {"run.duration": 0.2}
    result = simulate(load(settings), coupling="direct", realtime=True)
    assert time.monotonic() - begin >= 0.2
    report = result.summary["real_time"]
    assert report["steps"] == 201
    assert report["lateness"]["max"] >= report["lateness"]["median"] >= 0.0
    assert report["scheduling"]
    assert "real time   " in result.describe()
    plain = simulate(load(settings), coupling="direct")
    assert "real_time" not in plain.summary
    np.testing.assert_array_equal(plain.rows, result.rows)


@pytest.mark.slow
def test_a_run_that_cannot_keep_up_reports_it(monkeypatch: pytest.MonkeyPatch) -> None:
    step = PlantModel.step

    def slow(self: PlantModel, t: float, h: float) -> None:
        time.sleep(0.003)
        step(self, t, h)

    monkeypatch.setattr(PlantModel, "step", slow)
    result = simulate(load(SHORT), coupling="direct", realtime=True)
    report = result.summary["real_time"]
    assert report["kept_up"] is False
    assert report["behind"] >= 48
    assert report["lateness"]["median"] >= 0.002
    assert "did NOT keep up" in result.describe()


@pytest.mark.slow
def test_hardware_in_real_time(tmp_path: Path) -> None:
    begin = time.monotonic()
    result = run(load(REALTIME | {"run.duration": 0.3}), tmp_path / "out", realtime=True)
    assert time.monotonic() - begin > 0.3
    report = result.summary["real_time"]
    assert report["steps"] == 300
    exchanges = result.summary["hardware"]
    assert 0.0 < exchanges["round_trip"]["median"] <= exchanges["round_trip"]["max"]
    assert exchanges["oldest_state"] >= 0.0


@pytest.mark.slow
def test_a_run_may_approach_from_the_measured_positions(tmp_path: Path) -> None:
    """The device begins 0.3 rad from the start of the trajectory; an approach moves it there."""
    away = {"start.q": [-0.2, 0.3], "hardware.link": "loopback:", "hardware.use": True}
    settings = LOCKSTEP | away | {"run.duration": 0.2, "hardware.approach": 0.5}
    result = run(load(settings), tmp_path / "out")
    assert result.summary["duration"] == pytest.approx(0.7)
    np.testing.assert_allclose(result["q_d.joint_1"][[0, 500]], [-0.2, -0.5], atol=1e-9)
    np.testing.assert_allclose(result["qd_d.joint_1"][[0, 500]], 0.0, atol=1e-9)
    assert result.summary["tracking"]["max"] < 1e-3


def test_an_approach_in_operational_space_replaces_the_approach_of_the_reference() -> None:
    settings = LOCKSTEP | {"hardware.approach": 0.05, "run.duration": 2.01}
    made = load(settings, ARM)
    driven = with_approach(made)
    assert driven.reference.approach.duration == 0.05
    np.testing.assert_allclose(driven.reference.approach.start, [0.5, -0.45, 0.4], atol=1e-6)
    assert driven.run.duration == pytest.approx(2.01 - 2.0 + 0.05)
    assert with_approach(load(settings | {"hardware.use": False}, ARM)).reference == made.reference


@pytest.mark.slow
def test_the_second_variant_of_the_system_is_the_hardware(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cardsflow: CommandLine
) -> None:
    settings = {k: v for k, v in LOCKSTEP.items() if k not in ("hardware.link", "hardware.use")}
    build(load(settings), tmp_path)
    system = tmp_path / "system.ssp"
    ours = simulate_system(system)
    with pytest.raises(InputError, match=r"system\.ssp: hardware\.link: missing"):
        simulate_system(system, {"variant": "hardware"})
    assert "hardware" not in ours.summary
    monkeypatch.setenv(LINK, "loopback:")
    result = simulate_system(system, {"variant": "hardware"})
    for name in ours.names:
        np.testing.assert_array_equal(result[name], ours[name], err_msg=name)
    monkeypatch.delenv(LINK)
    out = tmp_path / "out"
    driven = cardsflow("run", system, "--hardware", "loopback:", "--realtime", "-o", out)
    assert driven[0] == 0
    assert "real time" in driven[1]
    summary = json.loads((out / "summary.json").read_text())
    assert summary["files"][RECORDING_FILE] == RECORDING_FILE
    hardware = summary["hardware"]
    assert (hardware["link"], hardware["mode"], hardware["missed"]) == ("loopback:", "lockstep", 0)
    assert hardware["round_trip"]["max"] > 0.0
    joint = read_recording(out / RECORDING_FILE).states[: len(ours.rows) - 1, 0]
    np.testing.assert_array_equal(joint, ours["q.joint_1"][1:])
    assert (
        cardsflow("run", system, "-o", out)[0] == 0
    )  # without hardware there is no second variant
    assert not (out / RECORDING_FILE).exists()


@pytest.mark.slow
def test_a_system_reports_the_missed_exchanges_of_its_hardware(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = {"run.duration": 0.4, "hardware.emulator.loss": 0.02, "hardware.emulator.seed": 3}
    build(load(settings), tmp_path)
    monkeypatch.setenv(LINK, "emulated:")
    result = simulate_system(tmp_path / "system.ssp", {"variant": "hardware"})
    assert result.summary["hardware"]["missed"] == result["missed"][-1] > 0
    assert result.summary["hardware"]["oldest_state"] == result["age"].max() > 0.0
    assert "real_time" not in result.summary, "in a time of its own"
    page = "\n".join(summary_tables(result.summary))
    missed = result.summary["hardware"]["missed"]
    assert f'<td>missed exchanges</td><td class="number">{missed}</td>' in page
    assert "<td>emulated:</td>" in page
    assert "late steps" not in page


def key_file(folder: Path, mode: int = 0o600, length: int = 32) -> Path:
    file = folder / "key.bin"
    file.write_bytes(bytes(range(length)))
    file.chmod(mode)
    return file


def test_fmus_do_not_contain_the_key(tmp_path: Path) -> None:
    file = key_file(tmp_path)
    files = build(load(LOCKSTEP | {"hardware.key_file": str(file)}), tmp_path / "fmus")
    for fmu in files.values():
        with zipfile.ZipFile(fmu) as archive:
            for name in archive.namelist():
                assert b"key.bin" not in archive.read(name)
                assert file.read_bytes() not in archive.read(name)


@pytest.mark.slow
def test_a_key_signs_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = key_file(tmp_path)
    signed = simulate(load(LOCKSTEP | {"hardware.key_file": str(file)}))
    assert signed.complete
    monkeypatch.setenv(KEY_FILE, str(file))
    assert simulate(load(LOCKSTEP)).complete
    monkeypatch.setenv(KEY_FILE, str(tmp_path / "none.bin"))
    with pytest.raises(Exception, match=r"none\.bin"):
        simulate(load(LOCKSTEP))


def test_invalid_keys_are_rejected_and_readable_ones_cause_a_warning(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="contains 8 bytes; a key needs at least 16"):
        read_key(key_file(tmp_path, length=8))
    with pytest.raises(InputError):
        read_key(tmp_path)
    file = key_file(tmp_path, 0o644)
    assert "chmod 600" in (key_warning(file, "key") or "")
    settings = LOCKSTEP | {"hardware.key_file": str(file)}
    assert "other users can read this key" in "\n".join(load(settings).warnings())
    assert not load(settings | {"hardware.use": False}).warnings()
    assert key_warning(key_file(tmp_path), "key") is None


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({}, "hardware.link: missing; specify the address"),
        ({"hardware.link": "pigeon://coop"}, "invalid hardware address 'pigeon://coop'"),
        ({"hardware.link": "udp://127.0.0.1:9", "hardware.key_file": "none.key"}, "none.key"),
    ],
)
def test_unreachable_hardware_is_bad_input_before_anything_is_built(
    settings: dict[str, Any], message: str, tmp_path: Path, cardsflow: CommandLine
) -> None:
    given = words(settings | {"hardware.use": True})
    assert message in cardsflow.error_line("run", PLANAR_2R, *given, "-o", tmp_path / "out")


@pytest.mark.slow
def test_an_error_with_a_long_trace_is_one_line(tmp_path: Path, cardsflow: CommandLine) -> None:
    """FMI 2.0 splits long messages, and errors of serial lines have a chain of causes."""
    gone = "serial:///dev/nowhere-at-all"
    out = ["-o", str(tmp_path / "out")]
    error = cardsflow.error_line("run", PLANAR_2R, "--hardware", gone, *out, code=1)
    assert error.startswith(
        "cardsflow: hardware.fmu failed at the start: initialization: cannot connect to"
    )


def test_the_environment_is_restored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(LINK, "udp://1.2.3.4:5")
    monkeypatch.delenv(RECORDING, raising=False)
    with Connection("loopback:", recording=tmp_path / "a.rec").exported():
        assert os.environ[LINK] == "loopback:"
        assert os.environ[RECORDING] == str(tmp_path / "a.rec")
    assert os.environ[LINK] == "udp://1.2.3.4:5"
    assert RECORDING not in os.environ
    with Connection().exported():
        assert os.environ[LINK] == "udp://1.2.3.4:5"


FULL = """
link = "udp://127.0.0.1:5005"
use = true
mode = "lockstep"
bind = "127.0.0.1"
max_missed = 7
watchdog = 0.03
timeout = 0.7
scale = 10.0
has_lengths = false
ramp_in = 0.3
ramp_down = 0.1
force_rate = 5000.0
max_tension = { cable_2 = 150.0 }
start_tolerance = { joint_1 = 0.2, joint_2 = 0.3 }
position_margin = 0.01
approach = 1.5
[motors]
command = "velocity"
stiffness = { cable_1 = 1e3, cable_2 = 2e3, cable_3 = 3e3, cable_4 = 4e3 }
damping = 2.0
spindle_radius = 0.01
encoder_scale = 651.9
offset = "start"
"""


def test_all_settings_are_read_and_packed(tmp_path: Path) -> None:
    made = load({"hardware": tomllib.loads(FULL)})
    own = made.hardware
    assert (own.link, own.use, own.mode, own.max_missed) == (
        "udp://127.0.0.1:5005",
        True,
        "lockstep",
        7,
    )
    assert own.max_tension == (np.inf, 150.0, np.inf, np.inf)
    assert own.force_rate == (5000.0,) * 4
    assert own.start_tolerance == (0.2, 0.3)
    assert own.motors.stiffness == (1e3, 2e3, 3e3, 4e3)
    assert own.motors.offset is None
    write_resources(made, tmp_path, with_hardware=True)
    read = Experiment.from_resources(tmp_path).hardware
    assert (read.use, read.approach) == (False, None)  # not part of the FMU
    assert {**vars_of(read), "use": True, "approach": 1.5} == vars_of(own)
    assert "hardware" not in json.loads(resource_bytes(made)["experiment.json"])


def vars_of(settings: HardwareSettings) -> dict[str, Any]:
    return {name: getattr(settings, name) for name in HardwareSettings.model_fields}


def test_the_table_hardware_has_defaults() -> None:
    own = load({}).hardware
    assert (own.use, own.link, own.mode, own.watchdog) == (False, "", "realtime", 0.02)
    assert own.motors.command == "force"
    assert load({"run.step": 0.01, "controller.period": 0.01}).hardware.watchdog == 0.05


@pytest.mark.slow
def test_an_approach_is_rejected_with_an_external_reference(tmp_path: Path) -> None:
    reference = build(load(SHORT), tmp_path)["reference"]
    settings = LOCKSTEP | {"hardware.approach": 0.1, "fmus.reference": str(reference)}
    with pytest.raises(
        InputError, match=r"hardware\.approach: is not supported with an external FMU as reference"
    ):
        simulate(load(settings))


@pytest.mark.slow
def test_an_external_fmu_may_replace_the_hardware(tmp_path: Path) -> None:
    other = build(load(SHORT | {"start.q": [0.1, 0.2]}), tmp_path)["plant"]
    settings = SHORT | {"fmus.hardware": str(other), "hardware.use": True}
    assert simulate(load(settings))["q.joint_1"][0] == 0.1


@pytest.fixture
def served() -> Iterator[DeviceServer]:
    """Serve a device in a thread of this process; return its address."""
    made = load(HELD | {"hardware.watchdog": 60.0})
    device = emulated_device(made, made.hardware)
    over = threading.Event()
    with DeviceServer(device, "udp://127.0.0.1:0") as server:
        thread = threading.Thread(target=server.run, args=(over.is_set,))
        thread.start()
        try:
            yield server
        finally:
            over.set()
            thread.join()


@pytest.mark.cases(1)
@pytest.mark.slow
@pytest.mark.parametrize("host", ["in-process", "worker"])
@pytest.mark.parametrize("times", [1, 2])
def test_ctrl_c_during_the_handshake(tmp_path: Path, host: str, times: int) -> None:
    """The run ends like after any other Ctrl-C, without temporary files."""
    out = tmp_path / "out"
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as silent:
        silent.bind(("127.0.0.1", 0))
        silent.settimeout(300.0)
        uri = f"udp://127.0.0.1:{silent.getsockname()[1]}"
        command = [sys.executable, "-m", "cardsflow_fmu.cli", "run", str(PLANAR_2R)]
        command += ["--hardware", uri, "-o", str(out)]
        with subprocess.Popen(
            command,
            env=os.environ | {"CARDSFLOW_FMU_HOST": host},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        ) as process:
            silent.recv(1000)
            for _ in range(times):
                process.send_signal(signal.SIGINT)
                time.sleep(0.1)
            _, error = process.communicate(timeout=300)
    assert (process.returncode, error) == (130, "cardsflow: interrupted\n")
    assert not out.exists()


@pytest.mark.cases(2)
@pytest.mark.slow
@pytest.mark.parametrize(
    ("host", "signal_"),
    [
        ("in-process", signal.SIGINT),
        ("in-process", signal.SIGHUP),
        ("in-process", signal.SIGKILL),
        ("worker", signal.SIGTERM),
        ("worker", signal.SIGKILL),
    ],
)
def test_every_end_of_a_run_is_in_the_safe_state(
    served: DeviceServer, tmp_path: Path, host: str, signal_: signal.Signals
) -> None:
    out = tmp_path / "out"
    watchdog = 5.0 if signal_ == signal.SIGKILL else 60.0
    settings = words(
        HELD
        | {
            "hardware.ramp_down": 0.1,
            "hardware.max_missed": 100_000,
            "hardware.watchdog": watchdog,
        }
    )
    command = [sys.executable, "-m", "cardsflow_fmu.cli", "run", str(PLANAR_2R), *settings]
    command += ["--hardware", served.uri, "-o", str(out)]
    device = served.device
    environment_ = os.environ | {"CARDSFLOW_FMU_HOST": host}
    with subprocess.Popen(
        command, env=environment_, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    ) as process:
        assert wait_until(lambda: device.counters["setpoints"] > 100 or process.poll() is not None)
        assert device.counters["setpoints"] > 100
        process.send_signal(signal_)
        assert wait_until(lambda: device.state == "safe")
        error = process.stderr.read()
    if signal_ == signal.SIGKILL:
        return
    assert process.returncode == 130
    assert error == "cardsflow: interrupted\n"
    assert device.counters["stops"] > 0
    assert device.counters["watchdog"] == 0
    summary = json.loads((out / "summary.json").read_text())
    assert (summary["status"], summary["error"]) == ("incomplete", "interrupted")
