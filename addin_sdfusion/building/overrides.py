"""User settings of single links and joints, which override the values of the design."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from ..robot.finding import Finding, Subject
from ..robot.finding_builders import error, unknown, warning
from ..robot.model.joint import Coordinate, Joint
from ..robot.model.robot import WORLD, Inertia
from ..settings import ExportSettings, JointSettings, LinkSettings


def override_masses(
    parts: Mapping[str, Inertia], settings: ExportSettings
) -> tuple[dict[str, Inertia], list[Finding]]:
    """Return the links with the chosen masses and proportionally scaled inertias."""
    links, findings = dict(parts), list(_invalid_settings("link", settings.of_links, parts))
    findings += _equal_names(settings, parts)
    for chosen in settings.of_links:
        part = parts.get(chosen.link)
        if part is None or chosen.mass is None or not 0.0 < chosen.mass < math.inf:
            continue
        if part.mass > 0.0:
            links[chosen.link] = part.scaled(chosen.mass / part.mass)
        else:
            problem = (
                f"has no mass in the design, so its mass cannot be set to {chosen.mass:g} kg: its "
                "centre of mass is unknown; give its bodies a material"
            )
            findings.append(warning(Subject("link", chosen.link), "mass-not-set", problem))
    return links, findings


def _equal_names(settings: ExportSettings, links: Collection[str]) -> Iterator[Finding]:
    """Yield an error for each link whose chosen name is the exported name of another link."""
    names = {each.link: each.exported_name for each in settings.of_links}
    for link, name in names.items():
        others = [other for other in links if other != link and names.get(other, other) == name]
        if name != link and link in links and (others or name == WORLD):
            reason = "is reserved" if name == WORLD else f"is also the name of link {others[0]!r}"
            problem = f"its exported name {name!r} {reason}; choose another one in Export"
            yield error(Subject("link", link), "bad-setting", problem)


def override_joint_settings(
    joints: Sequence[Joint], settings: ExportSettings
) -> tuple[tuple[Joint, ...], list[Finding]]:
    """Return the joints with the chosen effort, velocity, damping and friction."""
    chosen = {each.joint: each for each in settings.of_joints}
    names = [c.name for joint in joints for c in joint.coordinates]
    changed = tuple(
        joint.map_coordinates(lambda c: _apply(c, chosen.get(c.name))) for joint in joints
    )
    return changed, list(_invalid_settings("joint", settings.of_joints, names))


def _apply(c: Coordinate, chosen: JointSettings | None) -> Coordinate:
    if chosen is None:
        return c
    changes: dict[str, Any] = {}
    if chosen.damping is not None:
        changes["damping"] = chosen.damping
    if chosen.velocity is not None:
        changes["max_velocity"] = chosen.velocity
    if chosen.friction is not None:
        changes["friction"] = chosen.friction
    if chosen.effort is not None:
        changes |= {"tau_min": -chosen.effort, "tau_max": chosen.effort}
    return replace(c, **changes)


def _invalid_settings(
    kind: str, settings: Sequence[LinkSettings | JointSettings], names: Collection[str]
) -> Iterator[Finding]:
    """Yield findings on settings of unknown links or joints and on invalid values."""
    for each in settings:
        name = each.link if isinstance(each, LinkSettings) else each.joint
        if name not in names:
            problem = f"{unknown(kind, name, sorted(names))}; its settings are ignored"
            yield warning(Subject(kind, name), "setting-of-none", problem)
        if isinstance(each, LinkSettings):
            if each.mass is not None and not 0.0 < each.mass < math.inf:
                problem = f"its mass must be above 0 kg, not {each.mass:g}; choose it in Export"
                yield error(Subject(kind, name), "bad-setting", problem)
            continue
        for quantity in ("effort", "damping", "friction", "velocity"):
            value = getattr(each, quantity)
            if value is not None and not 0.0 <= value < math.inf:
                problem = f"its {quantity} must be 0 or above, not {value:g}; choose it in Export"
                yield error(Subject(kind, name), "bad-setting", problem)
