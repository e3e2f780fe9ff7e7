"""Links of a design: rigid groups called `EXPORT_<link>`, or components."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from ...muscles.point_names import natural_key
from ...robot.finding import Finding, Subject
from ...robot.finding_builders import error, warning
from ...robot.model.robot import WORLD
from ...snapshot import (
    LINK_PREFIX,
    ROOT,
    DesignSnapshot,
    GroupSnapshot,
    OccurrenceSnapshot,
    bare_name,
)
from .components import component_links

_COPIED = re.compile(r" ?\([0-9]+\)$")


@dataclass(frozen=True)
class Links:
    """The links of a design.

    Attributes:
        names: Names of the links, in order.
        of_occurrence: Link of each occurrence that belongs to a link, by path. It contains the
            root if the bodies of the root component are a link.
        from_groups: Whether rigid groups are links; otherwise components are links.
    """

    names: tuple[str, ...]
    of_occurrence: Mapping[str, str]
    from_groups: bool
    findings: tuple[Finding, ...] = ()

    def without(self, links: Iterable[str]) -> Links:
        """Return the links without some of them."""
        removed = set(links)
        if not removed:
            return self
        remaining = {path: link for path, link in self.of_occurrence.items() if link not in removed}
        return replace(
            self, names=tuple(n for n in self.names if n not in removed), of_occurrence=remaining
        )


def in_name_order(names: Iterable[str]) -> tuple[str, ...]:
    """Return names in natural order: numbers in names are compared as numbers."""
    return tuple(sorted(names, key=lambda name: (natural_key(name), name)))


def is_link_group(group: GroupSnapshot) -> bool:
    """Return whether the name of a rigid group marks it as a link."""
    return group.name.startswith(LINK_PREFIX)


def uses_groups(snapshot: DesignSnapshot) -> bool:
    """Return whether the links of a design are rigid groups."""
    if snapshot.settings.links != "auto":
        return snapshot.settings.links == "rigid_groups"
    return any(is_link_group(group) and not group.suppressed for group in snapshot.groups)


def find_links(snapshot: DesignSnapshot) -> Links:
    """Return the links of a design."""
    by_groups = uses_groups(snapshot)
    named, findings = (_from_groups if by_groups else component_links)(snapshot)
    findings += _suppressed_groups(snapshot.groups)
    if WORLD in named.values():
        problem = "the name is reserved for the fixed frame; rename the rigid group or component"
        findings.append(error(Subject("link", WORLD), "reserved-name", problem))
        named = {path: f"{link}_" if link == WORLD else link for path, link in named.items()}
    of_occurrence = inherit_links(snapshot.occurrences, named)
    return Links(in_name_order(set(named.values())), of_occurrence, by_groups, tuple(findings))


def inherit_links(
    occurrences: Sequence[OccurrenceSnapshot], named: Mapping[str, str]
) -> dict[str, str]:
    """Return the link of each occurrence: its link or the link of its nearest ancestor.

    The link of the root component is not inherited.
    """
    above = {occurrence.path: occurrence.parent for occurrence in occurrences}
    link_of = dict(named)
    for path in sorted(above):
        chain: list[str] = []
        at = path
        while at != ROOT and at in above and at not in link_of and at not in chain:
            chain.append(at)
            at = above[at]
        if at != ROOT and at in link_of:
            link_of.update(dict.fromkeys(chain, link_of[at]))
    return link_of


def _from_groups(snapshot: DesignSnapshot) -> tuple[dict[str, str], list[Finding]]:
    """Return the link of each occurrence that is a group member, by path, and the findings."""
    findings = list(_misspelt_groups(snapshot.groups))
    paths = {ROOT, *(occurrence.path for occurrence in snapshot.occurrences)}
    groups_of: dict[str, list[str]] = {}
    names: list[str] = []
    for group in sorted(snapshot.groups, key=lambda g: (natural_key(g.name), g.name)):
        if group.suppressed or not is_link_group(group):
            continue
        members = sorted(paths.intersection(group.occurrences))
        if not members:
            problem = "has no components and is not a link; add components or delete the group"
            findings.append(warning(Subject("group", group.name), "empty-group", problem))
            continue
        names.append(bare_name(group.name))
        for path in members:
            groups_of.setdefault(path, []).append(group.name)
    findings += [*_duplicates(names), *_group_conflicts(groups_of)]
    if not names:
        problem = (
            f"nothing to export: no rigid group is called {LINK_PREFIX}<link>; create one for the "
            "components of each link, or choose components as links in Export"
        )
        findings.append(error(Subject("design", snapshot.name), "nothing-to-export", problem))
    # The smaller group takes precedence: a large one may also list children of its members.
    sizes = Counter(group for groups in groups_of.values() for group in groups)
    meant = {path: min(groups, key=lambda g: (sizes[g], g)) for path, groups in groups_of.items()}
    return {path: bare_name(group) for path, group in meant.items()}, findings


def _suppressed_groups(groups: Sequence[GroupSnapshot]) -> Iterator[Finding]:
    for name in in_name_order({g.name for g in groups if g.suppressed and is_link_group(g)}):
        problem = "is suppressed in the timeline and not exported; unsuppress it or rename it"
        yield warning(Subject("group", name), "suppressed-group", problem)


def _misspelt_groups(groups: Sequence[GroupSnapshot]) -> Iterator[Finding]:
    for name in in_name_order({g.name for g in groups if not is_link_group(g)}):
        if name.casefold().startswith(LINK_PREFIX.casefold()):
            problem = f"is not exported: names of links begin with {LINK_PREFIX}; rename it"
            yield warning(Subject("group", name), "misspelt-group", problem)


def _duplicates(names: Sequence[str]) -> Iterator[Finding]:
    for name in in_name_order(set(names)):
        subject = Subject("group", LINK_PREFIX + name)
        if names.count(name) > 1:
            problem = f"{names.count(name)} rigid groups have this name; rename all but one"
            yield error(subject, "duplicate-link", problem)
        if _COPIED.search(name):
            problem = "the number in brackets indicates a copy of another rigid group; rename it"
            yield warning(subject, "copied-name", problem)


def _group_conflicts(groups_of: Mapping[str, Sequence[str]]) -> Iterator[Finding]:
    for path, groups in sorted(groups_of.items()):
        if len(set(groups)) > 1:
            listed = ", ".join(map(repr, groups))
            problem = f"is in several rigid groups: {listed}; edit the groups and keep it in one"
            yield error(Subject("occurrence", path), "occurrence-in-two-groups", problem)
