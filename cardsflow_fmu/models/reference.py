"""Reference as an FMU model. Outputs are desired positions, velocities and accelerations."""

from __future__ import annotations

from itertools import chain

import numpy as np

from addin_sdfusion.robot.model.trajectory import Trajectory
from cardsflow_fmu.cosim.signals.dependencies import Dependencies, reference_dependencies
from cardsflow_fmu.cosim.signals.groups import Groups
from cardsflow_fmu.cosim.signals.ports import reference_groups
from cardsflow_fmu.experiment.experiment import Experiment
from controllers import (
    ApproachReference,
    FlowerReference,
    Reference,
    SequenceReference,
    SplineReference,
)

from .c_model import CModel
from .native.fields import Counts, Fields, encode


class ReferenceModel(CModel):
    """Reference and external loads, evaluated at the end of every step."""

    description = "Reference"
    any_step = True

    @staticmethod
    def groups(experiment: Experiment) -> Groups:
        """Return the variables for an experiment in named groups."""
        space, disturbance = experiment.reference.space, experiment.disturbance
        return reference_groups(
            experiment.robot,
            space,
            with_loads=disturbance is not None,
            has_speed=experiment.reacts_to_faults,
        )

    @classmethod
    def dependencies(cls, experiment: Experiment) -> Dependencies:
        """Return the dependencies of the outputs without creating the model."""
        return reference_dependencies(cls.groups(experiment))

    @classmethod
    def file(cls, experiment: Experiment) -> bytes:
        """Return the contents of the file `native.bin` of the model."""
        return encode("reference", b"", cls.groups(experiment), *_fields(experiment))


def make_reference(experiment: Experiment) -> Reference:
    """Create the reference of an experiment, including its approach."""
    settings = experiment.reference
    curve: Reference
    if isinstance(settings.curve, Trajectory):
        curve = SplineReference(settings.curve)
    else:
        flower = settings.curve
        curve = FlowerReference(
            flower.centre, flower.axes, flower.radius, flower.duration, flower.petals
        )
    if settings.approach is None:
        return curve
    approach = settings.approach
    lead = ApproachReference(approach.start, curve.evaluate(0.0).q, approach.duration)
    return SequenceReference([lead, curve])


def _fields(experiment: Experiment) -> tuple[Counts, Fields]:
    """Return the parts of the reference and the external forces; see `encode`."""
    counts, fields = reference_parts(experiment)
    faults = experiment.faults
    ramp = {"ramp": 0.0 if faults is None else faults.ramp}
    return counts, fields | _disturbance(experiment) | ramp


def reference_parts(experiment: Experiment | None) -> tuple[Counts, Fields]:
    """Return the parts of the reference of an experiment, or no parts; see `encode`."""
    reference = None if experiment is None else make_reference(experiment)
    parts = () if reference is None else reference.parts
    data = np.concatenate([[], *(part.data for part in parts)])
    fields: Fields = {
        "part_begin": [] if reference is None else reference.begins,
        "part_duration": [part.duration for part in parts],
        "part_kind": [part.kind for part in parts],
        "part_segments": [part.segments for part in parts],
        "part_powers": [part.powers for part in parts],
        "part_data": data,
    }
    return {"parts": len(parts), "part_numbers": data.size}, fields


def _disturbance(experiment: Experiment) -> Fields:
    disturbance = experiment.disturbance
    if disturbance is None:
        return {"load_begin": 0.0, "load_end": 0.0, "load_forces": []}
    return {
        "load_begin": disturbance.begin,
        "load_end": disturbance.end,
        "load_forces": list(chain.from_iterable(disturbance.forces)),
    }
