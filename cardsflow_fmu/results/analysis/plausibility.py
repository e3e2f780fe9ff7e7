"""Findings on input that is valid, but probably wrong: sizes, masses, moment arms, references."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from addin_sdfusion.robot import Finding, InputError, Subject
from addin_sdfusion.robot.checks.plausible import is_in_degrees, plausible
from addin_sdfusion.robot.finding_builders import warning
from cardsflow_fmu.experiment.experiment import Experiment
from sim_dart import control_dynamics

from .moment_arms import sign_changes

_STORED = "_plausibility_findings"
_POINTS = 200  # of a reference in joint space
_POSES = 20  # of a reference in operational space, for which inverse kinematics takes longer
_TOLERANCE = 1e-3, 1e-2
"""Distance beyond joint limits that is ignored: in [rad] or [m], and as fraction of the range."""


def plausibility_findings(experiment: Experiment) -> list[Finding]:
    """Return the findings on an experiment that a run prints before its first step."""
    stored = vars(experiment)  # as a cached property; searching sign changes takes seconds
    if _STORED not in stored:
        stored[_STORED] = _find(experiment)
    return stored[_STORED]  # type: ignore[no-any-return]


def experiment_warnings(experiment: Experiment) -> list[str]:
    """Return all warnings that are known before a run of an experiment, one line each."""
    unlikely = [finding.located for finding in plausibility_findings(experiment)]
    return [*experiment.warnings(), *unlikely]


def _find(experiment: Experiment) -> list[Finding]:
    robots = [part.robot for part in experiment.parts] or [experiment.robot]
    dynamics = control_dynamics(experiment.robot, may_be_singular=True)
    return [
        *(finding for robot in robots for finding in plausible(robot)),
        *sign_changes(experiment.robot, dynamics, np.array(experiment.start.q)),
        *reference_findings(experiment),
        *_reach_findings(experiment),
    ]


def reference_findings(experiment: Experiment) -> Iterator[Finding]:
    """Report coordinates with a reference in joint space beyond their limits, or in degrees."""
    from cardsflow_fmu.models.reference import make_reference

    if experiment.reference.space != "joint" or "reference" in experiment.fmus:
        return
    reference = make_reference(experiment)
    times = np.linspace(0.0, min(experiment.run.duration, reference.duration), _POINTS)
    q = reference.evaluate(times).q
    passive = experiment.controller.uncontrolled
    for k, c in enumerate(experiment.robot.coordinates):
        if passive and passive[k]:
            continue
        at = int(np.argmax(np.maximum(c.lower - q[:, k], q[:, k] - c.upper)))
        if np.isinf(c.lower) and np.isinf(c.upper):
            at = int(np.argmax(np.abs(q[:, k])))
        value = float(q[at, k])
        place = f"its reference is {value:.4g} {c.unit} at {times[at]:.3g} s"
        subject, in_degrees = Subject("coordinate", c.name), is_in_degrees(c, value)
        advice = "is it in degrees?" if in_degrees else "change the reference or the limits"
        absolute, relative = _TOLERANCE
        excess = max(c.lower - value, value - c.upper)
        if excess > min(absolute, relative * (c.upper - c.lower)):
            problem = f"{place}, outside its limits {c.lower:.4g} to {c.upper:.4g}; {advice}"
            yield warning(subject, "reference-outside-limits", problem)
        elif in_degrees:
            problem = f"{place}, which is {abs(value) / (2.0 * np.pi):.3g} turns; {advice}"
            yield warning(subject, "reference-in-degrees", problem)


def _reach_findings(experiment: Experiment) -> Iterator[Finding]:
    """Report the first point of a reference in operational space that is out of reach."""
    if experiment.reference.space == "joint" or "reference" in experiment.fmus:
        return
    from .sizing import reference_motion  # slow to import

    try:
        reference_motion(experiment, _POSES, rates=False)
    except InputError as error:
        yield warning(Subject("experiment", experiment.name), "motion-not-reached", str(error))
