"""The master of an experiment with its participants: FMUs, plain objects, or a loop in C."""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Literal, NamedTuple

from cardsflow_fmu.cosim.external_fmu import AdaptedFmu, fitting_wiring
from cardsflow_fmu.cosim.fmu_instance import FmuInstance
from cardsflow_fmu.cosim.master import Master
from cardsflow_fmu.cosim.participant import Participant
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.hardware.session.connect import Connection
from cardsflow_fmu.models.controller import ControllerModel
from cardsflow_fmu.models.direct_participant import DirectParticipant
from cardsflow_fmu.models.experiment_model import ExperimentModel
from cardsflow_fmu.models.hardware import HardwareModel
from cardsflow_fmu.models.plant import PlantModel
from cardsflow_fmu.models.reference import ReferenceModel
from cardsflow_fmu.native.loop import NativeLoop
from cardsflow_fmu.signals.ports import outer_signals
from cardsflow_fmu.signals.roles import HARDWARE, ROLES

Through = Literal["fmu", "direct", "native"]


MODELS: dict[str, type[ExperimentModel]] = {
    "plant": PlantModel,
    "controller": ControllerModel,
    "reference": ReferenceModel,
    HARDWARE: HardwareModel,
}


class PreparedFmu(NamedTuple):
    """An FMU that stands ready for several runs.

    Attributes:
        file: The .fmu.
        folder: Where it is unpacked, or empty.
        start_values: Values of its parameters, by name; its own where left out.
    """

    file: Path
    folder: Path
    start_values: Mapping[str, float] = {}


def performer(role: str, experiment: Experiment) -> str:
    """Whose model plays a role: the hardware's that of the plant, where it is used.

    Args:
        role: Plant, controller or reference.
        experiment: The experiment.
    """
    return HARDWARE if role == "plant" and experiment.hardware.use else role


@contextlib.contextmanager
def made_master(
    experiment: Experiment,
    fmus: Mapping[str, Path | PreparedFmu],
    streamed: Path | None,
    through: Through,
) -> Iterator[Master | NativeLoop]:
    """What steps the experiment, ready to run.

    Args:
        experiment: What to run.
        fmus: FMUs of participants, by the name of the model; the others are plain objects.
        streamed: Where exchanges with hardware are recorded; None for nowhere.
        through: What is stepped.

    Raises:
        InputError: An FMU cannot be used, or something is not in C where all is to be.
        SimulationError: A participant does not start.
    """
    if through == "native":
        with NativeLoop(experiment) as loop:
            yield loop
        return
    settings = experiment.run
    with _participants(experiment, fmus, streamed) as participants:
        yield Master(
            [participants[name] for name in ("plant", "reference", "controller")],
            fitting_wiring(
                experiment.wiring,
                experiment.fmus,
                participants.values(),
                outer_signals(experiment.robot, experiment.plant.wrenches),
            ),
            step=settings.step,
            steps=settings.steps,
            coupling=settings.coupling,
            every={"controller": round(experiment.controller.period / settings.step)},
        )


@contextlib.contextmanager
def _participants(
    experiment: Experiment, fmus: Mapping[str, Path | PreparedFmu], streamed: Path | None
) -> Iterator[dict[str, Participant]]:
    """The participants by name: an FMU where there is one, else the model itself.

    The plant comes last: hardware does not wait for long.
    """
    hardware = experiment.hardware
    connection = Connection(hardware.link, hardware.key_file, streamed)
    with contextlib.ExitStack() as stack:
        unpacked = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        participants: dict[str, Participant] = {}
        for role in reversed(ROLES):
            name = performer(role, experiment)
            model, external = MODELS[name], experiment.fmus.get(name)
            participant: Participant
            with connection.exported():
                if external is not None:
                    participant = FmuInstance(
                        role, external.file, unpacked / name, external.parameters
                    )
                elif name in fmus:
                    own = fmus[name]
                    if not isinstance(own, PreparedFmu):
                        own = PreparedFmu(own, unpacked / name)
                    participant = FmuInstance(role, *own)
                elif name == HARDWARE:
                    made = HardwareModel(experiment, connection=connection)
                    participant = DirectParticipant(role, made)
                else:
                    participant = DirectParticipant(role, model(experiment))
            stack.callback(participant.close)
            if external is not None:
                participant = AdaptedFmu(participant, external, model.table(experiment))
            participants[role] = participant
        yield participants
