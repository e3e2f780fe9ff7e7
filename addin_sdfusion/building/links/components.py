"""Links that are components, and their names."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from ...robot.finding import Finding, Subject
from ...robot.finding_builders import error, listed, unknown
from ...robot.transforms.joint_chains import Names
from ...snapshot import ROOT, DesignSnapshot, OccurrenceSnapshot, bare_name

ROOT_LINK = "base"
"""Name of the link with the bodies of the root component. It is not the name of the design, since
Fusion appends the version to that name and stored references to the link would become invalid."""

_FIRST = ":1"


def component_links(snapshot: DesignSnapshot) -> tuple[dict[str, str], list[Finding]]:
    """Return the links of a design whose links are components.

    Returns:
        The link of each occurrence that is a link, by path, and the findings.
    """
    occurrences = {occurrence.path: occurrence for occurrence in snapshot.occurrences}
    chosen, findings = _link_occurrences(snapshot, occurrences)
    named = _names(chosen, occurrences)
    for name, count in sorted(Counter(named.values()).items()):
        if count > 1:
            problem = f"{count} components have this link name; rename all but one of them"
            findings.append(error(Subject("link", name), "duplicate-link", problem))
    if any(body.occurrence == ROOT for body in snapshot.bodies):
        named[ROOT] = Names(named.values()).unique(ROOT_LINK)
    if not named and not findings:
        problem = "nothing to export: the design has no components and no bodies"
        findings.append(error(Subject("design", snapshot.name), "nothing-to-export", problem))
    return named, findings


def _link_occurrences(
    snapshot: DesignSnapshot, occurrences: Mapping[str, OccurrenceSnapshot]
) -> tuple[list[str], list[Finding]]:
    selected = snapshot.settings.components
    if not selected:
        return sorted(path for path, o in occurrences.items() if o.parent == ROOT), []
    findings: list[Finding] = []
    chosen: set[str] = set()
    for text in sorted(set(selected)):
        named = _paths_of(text, occurrences)
        if len(named) == 1:
            chosen.update(named)
            continue
        problem = (
            f"{listed(named)} have this name; use a path"
            if named
            else unknown("component", text, sorted(occurrences))
        )
        problem += "; choose the links in Export"
        findings.append(error(Subject("occurrence", text), "unknown-component", problem))
    return sorted(chosen), findings


def _paths_of(text: str, occurrences: Mapping[str, OccurrenceSnapshot]) -> list[str]:
    """Return the occurrences with a path, or else with a name such as `arm` or `arm:1`."""
    if text in occurrences:
        return [text]
    return sorted(
        path
        for path, o in occurrences.items()
        if text in (o.component, bare_name(o.component), path.removeprefix(f"{o.parent}+"))
    )


def _names(chosen: Sequence[str], occurrences: Mapping[str, OccurrenceSnapshot]) -> dict[str, str]:
    """Return the names of the links; equal names are prefixed with the names of the parents."""
    short = {path: _short_name(occurrences[path]) for path in chosen}
    counts = Counter(short.values())
    return {
        path: name if counts[name] == 1 else _long_name(path, occurrences)
        for path, name in short.items()
    }


def _short_name(occurrence: OccurrenceSnapshot) -> str:
    """Return `finger` for `hand:1+finger:1` and `finger_2` for `hand:1+finger:2`."""
    leaf = occurrence.path.removeprefix(f"{occurrence.parent}+" if occurrence.parent else "")
    number = leaf.rpartition(":")[2]
    name = bare_name(occurrence.component)
    if leaf.endswith(_FIRST) or not number.isdecimal():
        return name
    return f"{name}_{number}"


def _long_name(path: str, occurrences: Mapping[str, OccurrenceSnapshot]) -> str:
    names: list[str] = []
    seen = set()
    while path in occurrences and path not in seen:
        seen.add(path)
        names.insert(0, _short_name(occurrences[path]))
        path = occurrences[path].parent
    return "_".join(names)
