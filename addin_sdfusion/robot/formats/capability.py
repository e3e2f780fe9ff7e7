"""What a format does with each feature of a robot: a table that makes every finding of a loss.

A row of the table says of a feature whether the format keeps it, changes it, leaves it out, or
rejects the robot for it. All but the first come with the code and the message of a finding. The
message is a template: `{format}` is what the format is called, other words come with each place
where the feature is found.

    Capabilities("URDF", (
        kept(LINKS, DAMPING),
        left_out(LOOPS),                              # with the feature's own code and message
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

Fate = Literal["kept", "changed", "left out", "refused"]


class Found(NamedTuple):
    """A place where a robot has a feature.

    Attributes:
        subject: The object that has it.
        words: What its message has in braces.
    """

    subject: Subject
    words: Mapping[str, object] = {}


Finder = Callable[[Robot], Iterable[Found]]


@dataclass(frozen=True)
class Feature:
    """Something that a robot may have.

    Attributes:
        name: What messages and documents call it, in the plural.
        find: The places where a robot has it.
        code: Code of the finding that the format leaves it out; a row can override it.
        message: Of that finding.
    """

    name: str
    find: Finder
    code: str = ""
    message: str = "{format} has no {what}; left out"


@dataclass(frozen=True)
class Row:
    """What a format does with features.

    Attributes:
        features: Several are reported together, in one finding about the robot.
        fate: What becomes of them.
        code: Code of the finding; empty if the row makes no finding.
        message: Of the finding.
        find: The places that this is about.
        only: Which of these features this is about, for documents; empty for all.
    """

    features: tuple[Feature, ...]
    fate: Fate
    code: str = ""
    message: str = ""
    find: Finder = lambda robot: ()
    only: str = ""

    def findings(self, robot: Robot, format_: str) -> Iterator[Finding]:
        """Return the findings for a robot; `format_` is the name that messages use."""
        build = error if self.fate == "refused" else warning
        words = {"format": format_, "what": self.features[0].name}
        for place in self.find(robot) if self.code else ():
            problem = self.message.format_map({**words, **place.words})
            yield build(place.subject, self.code, problem)


def kept(*features: Feature) -> Row:
    """Return a row for features that the format holds as they are."""
    return Row(features, "kept")


def implied(*features: Feature) -> Row:
    """Return a row for features that are left out with another one, whose finding is enough."""
    return Row(features, "left out")


def _row(
    fate: Fate,
    feature: Feature | str,
    code: str = "",
    message: str = "",
    find: Finder | None = None,
    only: str = "",
) -> Row:
    """Return a row for a feature that is not simply kept.

    Args:
        fate: What becomes of it.
        feature: One of several formats, or the name of one that this format alone knows.
        code: Of the finding; the feature's if empty.
        message: Of the finding; the feature's if empty.
        find: The places that this is about; those of the feature if None.
        only: Which of these this is about, for documents.
    """
    if isinstance(feature, str):
        feature = Feature(feature, find or (lambda robot: ()))
    code, message = code or feature.code, message or feature.message
    return Row((feature,), fate, code, message, find or feature.find, only)


left_out = partial(_row, "left out")
"""A row, as `_row`, for a feature that is not written; the rest of the robot is."""
changed = partial(_row, "changed")
"""A row, as `_row`, for what is written but comes out otherwise in other programs."""
refused = partial(_row, "refused")
"""A row, as `_row`, for what makes that a robot is not written at all."""


def changed_together(features: Sequence[Feature], code: str, message: str) -> Row:
    """A row for features with one finding about the robot: `{what}` are those that it has."""

    def find(robot: Robot) -> Iterator[Found]:
        there = [f.name for f in features if any(True for _ in f.find(robot))]
        if there:
            yield Found(Subject("robot", robot.name), {"what": ", ".join(there)})

    return Row(tuple(features), "changed", code, message, find)


def in_every_set(*rows: Row) -> tuple[Row, ...]:
    """Return rows of muscles, which look in all cable sets in place of the active one."""
    return tuple(replace(row, find=_in_every_set(row.find)) for row in rows)


def _in_every_set(find: Finder) -> Finder:
    def find_all(robot: Robot) -> Iterator[Found]:
        for group in robot.cable_sets:
            for subject, words in find(replace(robot, cable_set=group.name)):
                yield Found(member(*subject, group.name, robot.cable_set), words)

    return find_all


@dataclass(frozen=True)
class Capabilities:
    """The table of a format.

    Attributes:
        title: What messages call the format.
        rows: Every feature, at least once.
    """

    title: str
    rows: tuple[Row, ...]

    def losses(self, robot: Robot) -> list[Finding]:
        """Everything that the format does not hold of a valid robot as it is.

        Returns:
            Errors, for which it is not written, then warnings.
        """
        return errors_first(f for row in self.rows for f in row.findings(robot, self.title))


def require_writable(findings: Sequence[Finding], format_: str) -> None:
    """Reject to write if there are errors.

    Args:
        findings: What the format cannot hold.
        format_: Its name in `convert`.

    Raises:
        RobotError: One of the findings is an error.
    """
    if any(finding.is_error for finding in findings):
        raise RobotError(findings, format_=format_)
