"""The estimator as an FMU model: readings in; state, loads and validity out."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.signals.dependencies import Dependencies, sampled_dependencies
from cardsflow_fmu.signals.estimation import estimator_groups, measured_muscles
from cardsflow_fmu.signals.groups import Groups
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.multiples import MOST_STEPS, whole_steps
from sim_dart.estimation.estimator import STATUSES, PoseEstimator

from .experiment_model import ExperimentModel


def make_estimator(experiment: Experiment) -> PoseEstimator:
    """The estimator of an experiment."""
    settings = experiment.estimator
    if settings is None:
        raise InputError("there is no [estimator] in the experiment", key="estimator")
    return PoseEstimator(
        experiment.robot, settings.believed, experiment.start.q, settings.inertial_units
    )


class EstimatorModel(ExperimentModel):
    """The estimator, which ticks once a step with the inputs at its beginning.

    The first tick takes its readings as those of the start; every other one moves the state on by
    the length of the step before. Where readings come late, ticks before the first one do nothing.
    """

    description = "Estimator of the state from muscles"

    def __init__(self, experiment: Experiment, values: FloatArray | None = None) -> None:
        super().__init__(experiment, values)
        self._estimator = make_estimator(experiment)
        robot, views = experiment.robot, self.views
        self._readings = [
            views[name] for name in ("lengths", "measured_tensions", "measured_torques", "encoders")
        ]
        self._units = views["gyroscopes"], views["accelerometers"]
        self._estimate = [views[name] for name in ("q", "qd", "w", "sd")]
        self._report, self._q_start = views["report"], views["q_start"]
        self._offsets, self._step = views["offsets"], views["step"]
        self._muscles = measured_muscles(robot)
        self._motors = [j for j, c in enumerate(robot.coordinates) if c.actuated]
        assert experiment.estimator is not None
        self._encoded = experiment.estimator.encoded
        self._delay = experiment.estimator.delay(experiment.run.step)
        self._since = -self._delay  # steps from the last tick to the next; below 0, ticks to wait

    @staticmethod
    def groups(experiment: Experiment) -> Groups:
        """The variables for an experiment in named groups."""
        settings = experiment.estimator
        assert settings is not None
        assert settings.offset is not None  # numbers, once an experiment is read
        return estimator_groups(
            experiment.robot,
            settings.encoded,
            settings.links,
            experiment.start.q,
            settings.offset,
            experiment.run.step,
        )

    @classmethod
    def dependencies(cls, experiment: Experiment) -> Dependencies:
        """What the outputs depend on, without making the model."""
        groups = cls.groups(experiment)
        return sampled_dependencies(groups, at_start={"q": "q_start"})

    def initialize(self, t: float = 0.0) -> None:
        """Go to the start, which is valid where it is known."""
        estimator = self._estimator
        if not 0 < self._step[0] < 1e9:
            what = f"the estimator's step must be a positive time in s, not {self._step[0]!r}"
            raise InputError(what)
        estimator.array("start", -1)[:] = self._q_start
        estimator.array("offset", -1)[self._muscles] = self._offsets
        estimator.reset()
        self._since = -self._delay
        self._write_outputs()

    def step(self, t: float, h: float) -> None:
        """A tick with the readings at t."""
        step, steps = float(self._step[0]), self._since
        since = whole_steps(h, step, "the estimator's internal step", most=MOST_STEPS)
        if steps < 0:
            self._since += 1
            return
        self._since = since
        estimator, (lengths, tensions, torques, encoders) = self._estimator, self._readings
        estimator.lengths[self._muscles], estimator.tensions[self._muscles] = lengths, tensions
        estimator.torques[self._motors] = torques
        estimator.encoders[self._encoded] = encoders
        gyroscopes, accelerometers = self._units
        estimator.gyroscope[:] = gyroscopes.reshape(-1, 3)
        # the first reading has no step whose acceleration it could tell
        estimator.accelerometer[:] = accelerometers.reshape(-1, 3) if steps else np.nan
        estimator.tick(step, steps)
        self._write_outputs()

    def get_state(self) -> bytes:
        """State and covariance, and the length of the last step."""
        return np.concatenate([[self._since], self._estimator.get_state()]).tobytes()

    def set_state(self, state: bytes) -> None:
        """Go back to a state from `get_state`."""
        size = 8 * (1 + self._estimator.get_state().size)
        if len(state) != size:
            raise InputError(f"a state of this estimator has {size} bytes, not {len(state)}")
        numbers = np.frombuffer(state)
        self._since = int(numbers[0])
        self._estimator.set_state(numbers[1:])
        self._write_outputs()

    def _write_outputs(self) -> None:
        """The estimate; the last one where it is lost to what is no number."""
        estimator, n = self._estimator, len(self._q_start)
        values = [estimator.q, estimator.qd, estimator.w, estimator.sd[:n]]
        if all(np.isfinite(value).all() for value in values):
            for view, value in zip(self._estimate, values, strict=True):
                view[:] = value
        self._report[:] = (
            estimator.innovation,
            estimator.used,
            STATUSES.index(estimator.status),
            estimator.valid,
        )
