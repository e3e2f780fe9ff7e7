from __future__ import annotations

import ctypes
import math
import random
import struct
import subprocess
import sys
from pathlib import Path

import pytest
from fmpy import fmi2
from fmpy.fmi1 import FMICallException
from support.fmu.fmu_host import STEP, Host, environment, opened, plain_run, require_error, unpack
from toy_model import PORTS, REFERENCES, OtherToyModel, ToyModel

from cardsflow_fmu.fmu.description import FmiVersion

pytestmark = pytest.mark.native

FMI = ("2.0", "3.0")


@pytest.mark.parametrize("is_serialized", [False, True])
def test_rollback_is_exact(started: Host, is_serialized: bool) -> None:
    slave = started.slave
    started.drive(0, 20)
    state = slave.getFMUstate()
    if is_serialized:
        data = slave.serializeFMUstate(state)
        slave.freeFMUstate(state)
        state = slave.deSerializeFMUstate(data)
    first = started.drive(20, 60)
    for _ in range(2):
        slave.setFMUstate(state)
        assert (started.drive(20, 60) == first).all()
    slave.freeFMUstate(state)
    assert (first == plain_run(60)[20:]).all()


def test_every_variable_is_restored(started: Host) -> None:
    slave = started.slave
    started.set(gain=0.1, u=2.0)
    slave.setBoolean([REFERENCES["locked"]], [True])
    started.drive(0, 3)
    reals = [reference for reference, port in enumerate(PORTS) if not port.boolean]
    before = slave.getReal(reals), slave.getBoolean([1, 5, 9])
    state = slave.getFMUstate()
    slave.setBoolean([REFERENCES["locked"]], [False])
    started.set(gain=9.0, u=-7.0)
    started.drive(3, 9)
    slave.setFMUstate(state)
    slave.freeFMUstate(state)
    assert (slave.getReal(reals), slave.getBoolean([1, 5, 9])) == before


def test_state_can_be_overwritten(started: Host) -> None:
    slave = started.slave
    state = slave.getFMUstate()
    started.drive(0, 5)
    assert slave.fmi2GetFMUstate(slave.component, ctypes.byref(state)) == fmi2.fmi2OK
    first = started.drive(5, 9)
    slave.setFMUstate(state)
    slave.freeFMUstate(state)
    assert (started.drive(5, 9) == first).all()


def test_state_is_restored_in_another_instance(toy_fmu: Path) -> None:
    with opened(toy_fmu, toy_fmu) as (one, two):
        one.start(stiffness=7.0, gain=2.0)
        one.drive(0, 10)
        two.restore(one.save())
        assert (one.drive(10, 50) == two.drive(10, 50)).all()


OTHER_PROCESS = """
import sys
from pathlib import Path
from support.fmu.fmu_host import opened

with opened(Path(sys.argv[1])) as (host,):
    host.restore(Path(sys.argv[2]).read_bytes())
    print(host.drive(10, 50).tobytes().hex())
"""


@pytest.mark.slow
def test_state_is_restored_in_another_process(toy_fmu: Path, started: Host, tmp_path: Path) -> None:
    started.set(gain=2.0)
    started.drive(0, 10)
    (tmp_path / "state").write_bytes(started.save())
    command = [sys.executable, "-c", OTHER_PROCESS, str(toy_fmu), str(tmp_path / "state")]
    done = subprocess.run(command, env=environment(), capture_output=True, text=True, check=True)
    assert bytes.fromhex(done.stdout) == started.drive(10, 50).tobytes()


def test_parameters_of_the_state_are_applied(started: Host) -> None:
    slave = started.slave
    state = slave.getFMUstate()
    slave.reset()
    started.start(stiffness=1.0)
    slave.setFMUstate(state)
    slave.freeFMUstate(state)
    assert (started.drive(0, 10) == plain_run(10)).all()


def test_state_resolves_an_error(started: Host) -> None:
    slave = started.slave
    started.drive(0, 5)
    state = slave.getFMUstate()
    started.set(fail_at=0.0)
    require_error(lambda: slave.doStep(5 * STEP, STEP))
    slave.setFMUstate(state)
    slave.freeFMUstate(state)
    assert (started.drive(5, 50) == plain_run(50)[5:]).all()


def test_state_before_the_initialization(host: Host) -> None:
    slave = host.slave
    host.set(gain=0.3)
    state = slave.getFMUstate()
    host.set(gain=0.9)
    host.start()
    host.drive(0, 5)
    slave.setFMUstate(state)
    slave.freeFMUstate(state)
    host.start()
    assert (host.drive(0, 9) == plain_run(9, gain=0.3)).all()


def test_state_in_initialization_mode(host: Host) -> None:
    slave = host.slave
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    host.set(stiffness=3.0)
    for is_up_to_date in (False, True):
        if is_up_to_date:
            host.get("x")
        state = slave.getFMUstate()
        slave.exitInitializationMode()
        host.drive(0, 5)
        slave.setFMUstate(state)
        slave.freeFMUstate(state)
    slave.exitInitializationMode()
    assert (host.drive(0, 9) == plain_run(9, stiffness=3.0)).all()


def test_wrong_bytes_are_rejected(started: Host) -> None:
    slave = started.slave
    data = started.save()
    for wrong in (b"", data[:-1], data + b"\0", data[:40], b"\1" + data[1:]):
        require_error(lambda wrong=wrong: slave.deSerializeFMUstate(wrong))
        assert started.last.startswith("deSerializeFMUstate: the state")
    assert (started.drive(0, 5) == plain_run(5)).all()


def test_damaged_bytes_have_no_effect(toy_fmu: Path) -> None:
    rng = random.Random(1)
    with opened(toy_fmu) as (host,):
        host.start()
        data = host.save()
        for _ in range(300):
            wrong = bytearray(data)
            for _ in range(rng.randint(1, 4)):
                wrong[rng.randrange(len(wrong))] = rng.randrange(256)
            go_to(host, bytes(wrong))
        host.slave.reset()
        host.start()
        assert (host.drive(0, 5) == plain_run(5)).all()


def test_serialized_state_of_another_fmu_is_rejected(
    toy_fmu: Path, tmp_path: Path, fmi: FmiVersion
) -> None:
    other = unpack(tmp_path / "other", OtherToyModel, "other", fmi=fmi)
    with opened(toy_fmu, other) as (one, two):
        one.start()
        data = one.save()
        require_error(lambda: two.slave.deSerializeFMUstate(data))
        assert two.last == "deSerializeFMUstate: the state belongs to another FMU"


def test_state_that_the_model_rejects_is_reported(
    started: Host, monkeypatch: pytest.MonkeyPatch
) -> None:
    slave = started.slave
    monkeypatch.setattr(ToyModel, "get_state", lambda self: b"short")
    state = slave.getFMUstate()
    require_error(lambda: slave.setFMUstate(state))
    slave.freeFMUstate(state)
    assert "unpack requires a buffer of 24 bytes" in started.last


def test_small_buffer_is_rejected(started: Host) -> None:
    slave = started.slave
    state = slave.getFMUstate()
    room = ctypes.create_string_buffer(3)
    require_error(lambda: slave.fmi2SerializeFMUstate(slave.component, state, room, 3))
    slave.freeFMUstate(state)
    assert "buffer is too small" in started.last


def go_to(host: Host, data: bytes) -> None:
    """Restore a damaged state if the FMU accepts it."""
    try:
        state = host.slave.deSerializeFMUstate(data)
    except FMICallException:
        return
    try:
        host.slave.setFMUstate(state)
        host.slave.doStep(0.0, STEP)
    except FMICallException:
        pass
    host.slave.freeFMUstate(state)


def test_states_with_invalid_numbers_are_rejected(started: Host) -> None:
    slave = started.slave
    started.drive(0, 5)
    data = started.save()
    header = struct.calcsize("<8s4I3Q3d")
    start_time, time = header - 24, header - 8
    places = [start_time, time, header, header + 8 * REFERENCES["gain"]]
    for place in places:
        for number in (math.nan, math.inf):
            wrong = data[:place] + struct.pack("<d", number) + data[place + 8 :]
            require_error(lambda wrong=wrong: slave.deSerializeFMUstate(wrong))
            assert started.last == "deSerializeFMUstate: the state is damaged"
    assert (started.drive(5, 9) == plain_run(9)[5:]).all()


def test_state_of_another_fmu_is_rejected(started: Host, fmi: FmiVersion, tmp_path: Path) -> None:
    with opened(unpack(tmp_path / "other", x_start=0.5, fmi=fmi)) as (other,):
        other.start()
        state = other.slave.getFMUstate()
        require_error(lambda: started.slave.setFMUstate(state))
        assert started.last == "setFMUstate: the state belongs to another FMU"
        other.slave.freeFMUstate(state)
    started.slave.reset()
    started.start()
    assert (started.drive(0, 5) == plain_run(5)).all()
