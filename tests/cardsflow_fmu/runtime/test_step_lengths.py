"""Invalid step lengths are rejected immediately by Python and native FMUs."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from fmpy import extract, fmi2, fmi3, read_model_description
from fmpy.fmi1 import FMICallException
from support.fmu.fmu_host import Host, require_error, running
from support.robots.robots import PLANAR_2R
from support.run_modes import COMPUTE

from cardsflow_fmu import Experiment
from cardsflow_fmu.fmu.description import FmiVersion
from cardsflow_fmu.models.plant import PlantModel
from cardsflow_fmu.simulation.build import build, build_fmus
from cardsflow_fmu.utils.multiples import StepLengthError

FMI = ("2.0", "3.0")
NO_STEP = (0.0, -1e-3, math.nan, math.inf, -math.inf)
REASONS = {"plant": "the plant's internal step", "controller": "the controller's period"}


@pytest.fixture(scope="module", params=[True, False], ids=["native", "python"])
def files(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> dict:
    experiment = Experiment.load(PLANAR_2R, {"run.duration": 0.1})
    folder = tmp_path_factory.mktemp("fmus")
    return build(experiment, folder, compute=COMPUTE[bool(request.param)])


@pytest.mark.native
@pytest.mark.parametrize("model", REASONS)
def test_too_long_steps_are_rejected(files: dict[str, Path], model: str, tmp_path: Path) -> None:
    """The message is correct, and the FMU does not try to compute the step."""
    for step in (1e6, 1e300, 100.001):
        with running(files[model], tmp_path / str(step)) as host:
            with pytest.raises(FMICallException) as caught:
                host.slave.doStep(0.0, step)
            assert caught.value.status == fmi2.fmi2Discard
            said = f"times {REASONS[model]}, 0.001 s; the maximum is 100000"
            assert said in host.last
            assert "\n" not in host.last


@pytest.mark.parametrize(
    "where", [pytest.param("native", marks=pytest.mark.native), "in-process", "worker"]
)
@pytest.mark.parametrize("model", REASONS)
def test_a_discarded_step_has_no_effect(
    model: str, where: str, fmi: FmiVersion, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The next step has a possible length."""
    if where == "worker" and model == "controller":
        pytest.skip("as slow as the plant, which is tested")
    experiment = Experiment.load(PLANAR_2R, {"run.duration": 0.1})
    monkeypatch.setenv("CARDSFLOW_FMU_HOST", where)
    options = {"fmi": fmi, "arrays": False, "native": where == "native", "sources": False}
    file = build_fmus(experiment, tmp_path, [model], **options)[model]
    rows = []
    for impossible in ((), (0.5e-3, 1e6, 1.5e-3)):
        with running(file, tmp_path / str(len(impossible))) as host:
            host.slave.doStep(0.0, 1e-3)
            for step in impossible:
                require_discard(host, step, reached=1e-3)
            host.slave.doStep(1e-3, 1e-3)
            rows.append(host.value({"plant": "q.joint_1", "controller": "f.cable_1"}[model]))
    assert rows[0] == rows[1]


@pytest.mark.parametrize("engine", ["core", "dart"])
def test_the_message_about_a_short_step_names_the_parameter(engine: str) -> None:
    """With this parameter, the plant accepts the step."""
    experiment = Experiment.load(PLANAR_2R, {"plant.engine": engine})
    plant = PlantModel(experiment)
    plant.initialize()
    with pytest.raises(StepLengthError, match="set the parameter step before the initialization"):
        plant.step(0.0, 0.5e-3)
    plant.views["step"][0] = 0.5e-3
    plant.initialize()
    plant.step(0.0, 0.5e-3)


def require_discard(host: Host, step: float, reached: float) -> None:
    with pytest.raises(FMICallException) as caught:
        host.slave.doStep(reached, step)
    assert caught.value.status == fmi2.fmi2Discard
    assert any(reason in host.last for reason in REASONS.values())
    if isinstance(host.slave, fmi2.FMU2Slave):
        assert host.slave.getRealStatus(fmi2.fmi2LastSuccessfulTime) == reached


@pytest.mark.native
@pytest.mark.parametrize("model", REASONS)
def test_zero_steps_are_rejected(files: dict[str, Path], model: str, tmp_path: Path) -> None:
    for step in NO_STEP:
        with running(files[model], tmp_path / str(step)) as host:
            require_error(lambda host=host, step=step: host.slave.doStep(0.0, step))
            assert host.last == f"doStep: invalid step of {step:.12g} s at 0 s"


@pytest.mark.native
def test_reset_restarts_a_dead_worker(files: dict[str, Path], tmp_path: Path) -> None:
    with running(files["plant"], tmp_path / "unpacked") as host:
        require_error(lambda: host.slave.doStep(0.0, -1.0))
        host.slave.reset()
        host.start()
        host.slave.doStep(0.0, 1e-3)


@pytest.mark.native
def test_the_event_mode_is_rejected_at_the_instantiation(tmp_path: Path) -> None:
    file = build(Experiment.load(PLANAR_2R), tmp_path, fmi="3.0", compute="c")["plant"]
    folder = extract(str(file), str(tmp_path / "unpacked"))
    description = read_model_description(folder)
    slave = fmi3.FMU3Slave(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
    )
    with pytest.raises(Exception, match="instantiate"):
        slave.instantiate(eventModeUsed=True)
    slave.instantiate()
    slave.freeInstance()
