"""Tab with the tools: mirror muscles, replace a link or a part."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ....muscles.point_names import natural_key
from ....robot.model.pose import X, Y, Z
from ....robot.model.robot import WORLD
from ...dialogs import Input
from ..model.links import used_links
from ..model.model import MuscleModel
from ..model.parts import used_parts
from .muscles import OF_PART

if TYPE_CHECKING:
    from ...inputs import Inputs

PLANES = {
    "YZ plane (x changes sign)": X,
    "XZ plane (y changes sign)": Y,
    "XY plane (z changes sign)": Z,
}
"""Planes through the origin of the design, with their normals."""
PICKED_PLANE = "A picked plane"
NO_LINK = NO_PART = "(no points yet)"

TAB = Input(
    "tab_tools",
    "tab",
    "Mirror, links",
    children=(
        Input(
            "mirror_group",
            "group",
            "Mirror left to right",
            children=(
                Input(
                    "plane",
                    "dropdown",
                    "Plane",
                    "Mirror plane: a plane through the origin of the design, or a picked plane.",
                    options=(*PLANES, PICKED_PLANE),
                    value=next(iter(PLANES)),
                ),
                Input(
                    "plane_pick",
                    "selection",
                    "Picked plane",
                    "A flat face or a construction plane.",
                    filters=("PlanarFaces", "ConstructionPlanes"),
                    prompt="Pick the mirror plane",
                ),
                Input(
                    "mirror_all",
                    "check",
                    "All muscles of this side",
                    "Mirrors all muscles of this side instead of only the chosen one.",
                ),
                Input(
                    "mirror_replace",
                    "check",
                    "Replace",
                    "Replaces existing muscles of the other side.",
                ),
                Input(
                    "mirror",
                    "button",
                    "Mirror",
                    "The sides of links and muscles are marked by l, left, r or right at the "
                    "beginning or end of a name: arm_l and arm_r, LeftArm and RightArm.",
                ),
            ),
        ),
        Input(
            "links_group",
            "group",
            "Replace a link",
            children=(
                Input("old_link", "dropdown", "Link", "The link that points and surfaces name."),
                Input(
                    "new_link",
                    "dropdown",
                    "By",
                    "Another link, or the link of the part that each point lies on.",
                    options=(OF_PART,),
                    value=OF_PART,
                ),
                Input(
                    "replace_link",
                    "button",
                    "Replace",
                    "Moves all points and wrap surfaces of the link at once, for example after "
                    "a link was renamed.",
                ),
            ),
        ),
        Input(
            "parts_group",
            "group",
            "Replace a part",
            children=(
                Input("old_part", "dropdown", "Part", "The part that points and surfaces lie on."),
                Input("new_part", "dropdown", "By", "Another part."),
                Input(
                    "replace_part",
                    "button",
                    "Replace part",
                    "Moves all points and wrap surfaces of the part, and of the parts in it, to "
                    "the same places on the other part. This also repairs points that are not "
                    "found because the part was deleted or replaced.",
                ),
            ),
        ),
    ),
)


def show(model: MuscleModel, inputs: Inputs) -> None:
    """Show the links and parts that can be replaced."""
    used = used_links(model.table)
    old, new = inputs.value("old_link"), inputs.value("new_link")
    inputs.choose("old_link", used or (NO_LINK,), old if old in used else (used or [NO_LINK])[0])
    choices = (OF_PART, *model.links, WORLD)
    inputs.choose("new_link", choices, new if new in choices else OF_PART)
    parts, every = used_parts(model.table), sorted(filter(None, model.link_of), key=natural_key)
    for name, options in (("old_part", parts), ("new_part", every)):
        chosen = inputs.value(name)
        chosen = chosen if chosen in options else (options or [NO_PART])[0]
        inputs.choose(name, options or (NO_PART,), chosen)
