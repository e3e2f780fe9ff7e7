"""Tables of the features that a format keeps, changes, omits or rejects.

Each row states whether the format keeps a feature, changes it, omits it, or rejects the robot
because of it. All rows except kept features also define the code and the message of a finding. The
message is a template: `{format}` is the title of the format, and a feature may define further
placeholders.

    Capabilities("URDF", (
        kept(LINKS, DAMPING),
        omitted(LOOPS),  # with the code and message of the feature
        changed(LIMITS, "one-sided-limit", "{format} limits both sides or none"),
    ))
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal, NamedTuple

from ..errors import RobotError
from ..finding import Finding, Subject, errors_first, member
from ..finding_builders import error, warning
from ..model.robot import Robot

Treatment = Literal["kept", "changed", "omitted", "rejected"]


class FeaturePlace(NamedTuple):
    """A place where a robot has a feature.

    Attributes:
        subject: The object that has the feature.
        words: Values of the placeholders in the message.
    """

    subject: Subject
    words: Mapping[str, object] = {}


Finder = Callable[[Robot], Iterable[FeaturePlace]]


@dataclass(frozen=True)
class Feature:
    """Property or element that a robot may have.

    Attributes:
        name: Name in messages and documents, in the plural.
        find: Function that returns the places where a robot has the feature.
        code: Code of the finding that the format omits the feature; a row can override it.
        message: Message of that finding.
    """

    name: str
    find: Finder
    code: str = ""
    message: str = "{format} has no {feature}; omitted"


@dataclass(frozen=True)
class Row:
    """Treatment of one or several features by a format.

    Attributes:
        features: The features. Several features share one finding about the robot.
        treatment: The treatment of the features.
        code: Code of the finding; empty if the row has no finding.
        message: Message of the finding.
        find: Function that returns the places to report.
        only: The affected part of the features, for documents; empty for all of them.
    """

    features: tuple[Feature, ...]
    treatment: Treatment
    code: str = ""
    message: str = ""
    find: Finder = lambda robot: ()
    only: str = ""

    def findings(self, robot: Robot, format_: str) -> Iterator[Finding]:
        """Return the findings for a robot; `format_` is the name that messages use."""
        build = error if self.treatment == "rejected" else warning
        words = {"format": format_, "feature": self.features[0].name}
        for place in self.find(robot) if self.code else ():
            problem = self.message.format_map({**words, **place.words})
            yield build(place.subject, self.code, problem)


def kept(*features: Feature) -> Row:
    """Return a row for features that the format keeps unchanged."""
    return Row(features, "kept")


def omitted_together(*features: Feature) -> Row:
    """Return a row for features that are omitted together with a feature that is reported."""
    return Row(features, "omitted")


def _row(
    treatment: Treatment,
    feature: Feature | str,
    code: str = "",
    message: str = "",
    find: Finder | None = None,
    only: str = "",
) -> Row:
    """Return a row for a feature that the format changes, omits or rejects.

    Args:
        feature: A feature of the catalogue, or the name of a feature that only this format has.
        code: Code of the finding; the code of the feature if empty.
        message: Message of the finding; the message of the feature if empty.
        find: Function that returns the places to report; `feature.find` if None.
        only: The affected part of the feature, for documents.
    """
    if isinstance(feature, str):
        feature = Feature(feature, find or (lambda robot: ()))
    code, message = code or feature.code, message or feature.message
    return Row((feature,), treatment, code, message, find or feature.find, only)


omitted = partial(_row, "omitted")
"""Return a row (see `_row`) for a feature that is not written."""
changed = partial(_row, "changed")
"""Return a row (see `_row`) for a feature that is written but differs in other programs."""
rejected = partial(_row, "rejected")
"""Return a row (see `_row`) for a feature that prevents the writing of the robot."""


def changed_together(features: Sequence[Feature], code: str, message: str) -> Row:
    """Return a row that reports several features in one finding; `{feature}` lists those found."""

    def find(robot: Robot) -> Iterator[FeaturePlace]:
        names = [f.name for f in features if any(True for _ in f.find(robot))]
        if names:
            yield FeaturePlace(Subject("robot", robot.name), {"feature": ", ".join(names)})

    return Row(tuple(features), "changed", code, message, find)


def in_all_sets(*rows: Row) -> tuple[Row, ...]:
    """Return the rows, extended from the active cable set to all cable sets."""
    return tuple(replace(row, find=_in_all_sets(row.find)) for row in rows)


def _in_all_sets(find: Finder) -> Finder:
    def find_all(robot: Robot) -> Iterator[FeaturePlace]:
        for group in robot.cable_sets:
            for subject, words in find(replace(robot, cable_set=group.name)):
                yield FeaturePlace(member(*subject, group.name, robot.cable_set), words)

    return find_all


@dataclass(frozen=True)
class Capabilities:
    """Table of the features that a format can hold.

    Attributes:
        title: Name of the format in messages.
        rows: The rows; each feature appears at least once.
    """

    title: str
    rows: tuple[Row, ...]

    def losses(self, robot: Robot) -> list[Finding]:
        """Return findings on all features of a valid robot that the format cannot keep.

        Returns:
            Errors, which prevent writing, then warnings.
        """
        return errors_first(f for row in self.rows for f in row.findings(robot, self.title))


def require_writable(findings: Sequence[Finding], format_: str) -> None:
    """Raise an error if the findings contain errors.

    Args:
        findings: Findings on features that the format cannot hold.
        format_: Name of the format in `convert`.

    Raises:
        RobotError: One of the findings is an error.
    """
    if any(finding.is_error for finding in findings):
        raise RobotError(findings, format_=format_)
