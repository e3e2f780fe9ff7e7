"""FMUs of FMI 3.0 with arrays, and functions that FMI 2.0 does not have."""

from __future__ import annotations

import ctypes
import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from array_model import ARRAYS, INDEX, PORTS, ArrayModel
from fmpy import fmi3
from fmpy.validation import validate_fmu
from support.fmu.fmu_host import load, pack, require_error

from addin_sdfusion.robot import SimulationError, UnknownNameError
from cardsflow_fmu.cosim.fmu_instance import FmuInstance
from cardsflow_fmu.models.direct_participant import DirectParticipant

pytestmark = pytest.mark.native

STEP = 1e-2


def write(path: Path, **changes: Any) -> Path:
    return pack(path, ArrayModel, PORTS, **{"fmi": "3.0", "step": STEP, **changes})


class Instance:
    """Instance with its log and the times of its intermediate updates."""

    def __init__(self, folder: Path) -> None:
        self.updates: list[tuple[float, float]] = []
        self.host = load(folder)
        self.slave: Any = self.host.slave
        self.slave.instantiate(logMessage=self.host.log, intermediateUpdate=self.update)

    def update(self, _: object, time: float, *flags: Any) -> None:
        assert [bool(flag) for flag in flags[:4]] == [False, True, True, False]
        (count,) = self.slave.getFloat64([ARRAYS["calls"]])
        self.updates.append((time, count))

    def start(self) -> None:
        self.host.start()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = write(tmp_path_factory.mktemp("arrays") / "two.fmu")
    fmpy.extract(str(path), str(path.parent / "two"))
    return path.parent / "two"


@pytest.fixture
def instance(folder: Path) -> Iterator[Instance]:
    made = Instance(folder)
    yield made
    made.slave.freeInstance()


@pytest.fixture
def started(instance: Instance) -> Instance:
    instance.start()
    return instance


def test_fmu_is_valid(tmp_path: Path) -> None:
    for arrays in (True, False):
        assert validate_fmu(str(write(tmp_path / "two.fmu", arrays=arrays))) == []


def test_variables_are_arrays(folder: Path) -> None:
    description = fmpy.read_model_description(str(folder))
    found = {v.name: v for v in description.modelVariables}
    assert {name: v.valueReference for name, v in found.items()} == ARRAYS
    assert found["u"].shape == (2,)
    assert found["u"].start == "0.0 0.5"
    assert found["on"].start == "true true"
    assert found["u"].unit == "N"
    assert found["x"].unit is None  # metres and radians
    assert found["calls"].shape == ()
    assert found["u"].description == "Force of a, b"


def test_arrays_can_be_read_and_set(started: Instance) -> None:
    slave = started.slave
    slave.setFloat64([ARRAYS["u"], ARRAYS["gain"]], [1.0, 2.0, 3.0, 4.0])
    slave.setBoolean([ARRAYS["on"]], [False, True])
    slave.doStep(0.0, STEP)
    model = ArrayModel()
    model.initialize()
    model.inputs[:], model.parameters[:2] = (1.0, 2.0, 0.0, 1.0), (3.0, 4.0)
    model.step(0.0, STEP)
    names = ["x", "calls", "u"]
    assert slave.getFloat64([ARRAYS[name] for name in names], 5) == [
        *model.outputs[:2],
        1.0,
        1.0,
        2.0,
    ]
    assert slave.getBoolean([ARRAYS["moving"]], 2) == [False, True]
    assert slave.getFloat64([ARRAYS["time"]]) == [STEP]


@pytest.mark.parametrize("size", [0, 1, 3, 1000])
def test_wrong_lengths_are_rejected(folder: Path, size: int) -> None:
    for call in (
        lambda slave: slave.getFloat64([ARRAYS["x"]], size),
        lambda slave: slave.setFloat64([ARRAYS["u"]], [1.0] * size),
        lambda slave: slave.getBoolean([ARRAYS["moving"]], size),
        lambda slave: slave.setBoolean([ARRAYS["on"]], [True] * size),
    ):
        made = Instance(folder)
        made.start()
        require_error(lambda call=call, made=made: call(made.slave))
        assert "values" in made.host.last
        made.slave.freeInstance()


def test_elements_have_no_value_reference(started: Instance) -> None:
    require_error(lambda: started.slave.getFloat64([INDEX["x.b"]]))
    assert "value reference 5 is within the array x" in started.host.last


def test_time_cannot_be_set(started: Instance) -> None:
    require_error(lambda: started.slave.setFloat64([ARRAYS["time"]], [1.0]))


def test_other_types_are_rejected(folder: Path) -> None:
    for name in ("Float32", "Int8", "UInt16", "Int32", "UInt64"):
        made = Instance(folder)
        made.start()
        require_error(lambda made=made, name=name: getattr(made.slave, f"get{name}")([0]))
        assert "Float64 and Boolean variables only" in made.host.last
        made.slave.freeInstance()


def test_every_step_has_an_intermediate_update(started: Instance) -> None:
    for k in range(3):
        assert started.slave.doStep(k * STEP, STEP) == (False, False, False, (k * STEP) + STEP)
    assert started.updates == [(k * STEP + STEP, k + 1.0) for k in range(3)]


def test_state_is_restored_in_another_instance(folder: Path) -> None:
    one, two = Instance(folder), Instance(folder)
    one.start()
    one.slave.setFloat64([ARRAYS["u"]], [1.5, -0.5])
    one.slave.doStep(0.0, STEP)
    two.host.restore(one.host.save())
    rows = []
    for made in (one, two):
        made.slave.doStep(STEP, STEP)
        rows.append(made.slave.getFloat64([ARRAYS[name] for name in ("x", "u", "calls")], 5))
        made.slave.freeInstance()
    assert rows[0] == rows[1]


def test_missing_resources_are_reported(folder: Path) -> None:
    slave = Instance(folder).slave
    messages: list[bytes] = []
    log = fmi3.fmi3LogMessageCallback(lambda *arguments: messages.append(arguments[-1]))
    none = fmi3.fmi3IntermediateUpdateCallback()
    references = (ctypes.c_uint * 0)()
    for path in (None, b"/no such folder/"):
        made = slave.fmi3InstantiateCoSimulation(
            b"x", b"y", path, False, False, False, False, references, 0, None, log, none
        )
        assert not made
        assert messages.pop()


def test_unsupported_interface_types_are_rejected(folder: Path) -> None:
    for kind in (fmi3.FMU3Model, fmi3.FMU3ScheduledExecution):
        description = fmpy.read_model_description(str(folder))
        slave = kind(
            guid=description.guid,
            unzipDirectory=str(folder),
            modelIdentifier="two",
            instanceName="two",
        )
        with pytest.raises(Exception, match="Failed to instantiate"):
            slave.instantiate()


def test_unsupported_optional_functions_report_errors(started: Instance) -> None:
    """Each of the other functions reports an error; the instance does not change."""
    slave = started.slave
    csrc = Path(__file__).parents[3] / "cardsflow_fmu/runtime/csrc"
    files = ("fmi3_unsupported.c", "fmi3_model_exchange.c")
    source = "".join((csrc / "fmi" / file).read_text() for file in files)
    defined = set(re.findall(r"(?: |_CALL\(|ARRAY\()(fmi3\w+)[(,]", source))
    names = [n for n, _ in inspect.getmembers(slave) if n in defined]
    assert len(names) == 31
    for name in names:
        if "Instantiate" in name:
            continue
        function = slave.dll[name]
        function.argtypes = None
        before = len(started.host.messages)
        arguments = [None] * 9
        assert function(ctypes.c_void_p(slave.component), *arguments) == fmi3.fmi3Error
        assert len(started.host.messages) == before + 1
        assert function(None, *arguments) == fmi3.fmi3Error
    slave.doStep(0.0, STEP)


def test_null_pointers(started: Instance) -> None:
    slave = started.slave
    component = ctypes.c_void_p(slave.component)
    for name in ("GetFloat64", "SetBoolean", "DoStep", "GetFMUState", "GetDirectionalDerivative"):
        function = slave.dll[f"fmi3{name}"]
        function.argtypes = None
        assert function(None, *[None] * 9) == fmi3.fmi3Error
    step = slave.dll["fmi3DoStep"]
    step.argtypes = None
    zero = ctypes.c_double(0.0), ctypes.c_double(STEP)
    assert step(component, *zero, False, None, None, None, None) == fmi3.fmi3Error
    assert started.host.last == "doStep: null pointer"


@pytest.mark.parametrize(("version", "arrays"), [("2.0", False), ("3.0", True), ("3.0", False)])
def test_participants_of_all_versions_agree(tmp_path: Path, version: str, arrays: bool) -> None:
    file = write(tmp_path / "two.fmu", fmi=version, arrays=arrays)
    fmu = FmuInstance("two", file, tmp_path / "two", {"gain.b": 0.25, "on.a": 0.0})
    model = ArrayModel()
    model.values[[INDEX["gain.b"], INDEX["on.a"]]] = 0.25, 0.0
    direct = DirectParticipant("two", model)
    order = [direct.output_names.index(name) for name in fmu.output_names]
    assert set(fmu.input_names) == set(direct.input_names)
    assert fmu.units == direct.units
    assert fmu.inputs.tolist() == [0.0, 0.5, 0.0, 1.0]
    for k in range(20):
        for one in (fmu, direct):
            one.inputs[one.input_names.index("u.a")] = np.sin(k)
            one.inputs[one.input_names.index("on.b")] = k % 3 > 0
            one.step(k * STEP, STEP)
        assert (fmu.outputs == direct.outputs[order]).all()
    with pytest.raises(SimulationError, match="the step starts at 0 s"):
        fmu.step(0.0, STEP)
    fmu.close()


def test_unknown_start_values(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match=r"gain\.c"):
        FmuInstance("two", write(tmp_path / "two.fmu"), tmp_path / "two", {"gain.c": 1.0})
