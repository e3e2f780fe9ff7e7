"""Makes the pictures of docs/tutorials/muscles_in_fusion.md with the fake Fusion.

python docs/make_addin_steps.py        needs Chromium

Each picture shows the design with the preview of the add-in, and the dialog of the add-in.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "docs"), str(ROOT / "tests"), str(ROOT / "tests/support")]

import fake_fusion  # noqa: E402
from addin_examples import Example  # noqa: E402
from fake_fusion import Builder  # noqa: E402
from fake_fusion.maths import point, rotation, translation  # noqa: E402
from make_addin_page import DEFINE, STYLE, shot, window  # noqa: E402

from addin_sdfusion.commands.dialogs import Input  # noqa: E402

IMAGES = ROOT / "docs/images/fusion"
VIEW = 520, 420
"""Width and height of the view of the design, in pixels."""
_SCALE = 14.0  # pixels per centimetre
_CENTRE = np.array([13.0, 0.0, 5.0])
_FORWARD = np.array([-0.45, 0.8, -0.4]) / np.linalg.norm([-0.45, 0.8, -0.4])
_RIGHT = np.cross(_FORWARD, [0.0, 0.0, 1.0]) / np.linalg.norm(np.cross(_FORWARD, [0.0, 0.0, 1.0]))
_UP = np.cross(_RIGHT, _FORWARD)
_LIGHT = np.array([0.2, -0.7, 0.7])
_LAYOUT = "<style>body { margin: 6px; display: flex; gap: 8px; zoom: 0.75 }</style>"


class Step(NamedTuple):
    """A step of the how-to.

    Attributes:
        name: Name of the picture.
        page: The picture as HTML.
        clicks: Number of clicks up to this step.
    """

    name: str
    page: str
    clicks: int


def steps() -> Iterator[Step]:
    """Define two muscles over a wrap surface, and yield a picture after each step."""
    with fake_fusion.install() as fusion:
        from addin_sdfusion import addin_sdfusion

        addin_sdfusion.run(None)
        _draw_arm()
        root = fusion.design.rootComponent
        torso, arm = (root.occurrences.itemByName(f"{name}:1") for name in ("torso", "arm"))
        command = fusion.run_command("cardsflowDefineMuscles")

        def pick(body: Any, face: int, places: Sequence[Sequence[float]]) -> None:
            for place in places:
                command.pick("pick", body.faces.item(face), point(place))

        def step(name: str, tab: str, clicked: Sequence[Sequence[float]] = ()) -> Step:
            before = command.clicks
            command.tab(tab)
            command.clicks = before  # the user stays on the tab
            return Step(name, _page(root, command, tab, clicked), before)

        above = [(0.0, 0.0, 15.0), (9.0, 0.0, 12.0), (17.0, 0.0, 12.0), (28.0, 0.0, 12.0)]
        below = [(0.0, -3.0, -5.0), (9.0, 0.0, 8.0), (17.0, 0.0, 8.0), (28.0, 0.0, 8.0)]
        pick(torso.bRepBodies.item(0), 5, above[:1])
        pick(arm.bRepBodies.item(0), 5, above[1:])
        yield step("1_first_muscle", "tab_muscles", above)
        command.press("new_muscle")
        pick(torso.bRepBodies.item(0), 2, below[:1])
        pick(arm.bRepBodies.item(0), 4, below[1:])
        yield step("2_second_muscle", "tab_muscles", below)
        command.tab("tab_muscles")
        command.set("muscle", "motor0")
        command.pick("wrap_pick", arm.bRepBodies.item(1).faces.item(0))
        command.press("use_add")
        command.set(command.cell("wrap_uses", 1, 1).id, 1)
        yield step("3_wrap_surface", "tab_wraps")
        command.tab("tab_motion")
        command.set("motion_percent", 70.0)
        yield step("4_motion", "tab_motion")
        command.ok()
        assert not command.failed, command.failed
        addin_sdfusion.stop(None)


def _draw_arm() -> None:
    """Draw a torso with an arm that rotates about y, and a cylinder on the arm."""
    build = Builder("robot")
    torso = build.place("torso", translation((0.0, 0.0, 5.0)), grounded=True)
    arm = build.place("arm", translation((18.0, 0.0, 10.0)))
    build.box(torso, (6.0, 6.0, 20.0))
    build.box(arm, (26.0, 5.0, 4.0))
    build.cylinder(arm, 3.0, 6.0, translation((-5.0, 0.0, 1.5)) @ rotation(np.pi / 2, (1, 0, 0)))
    build.joint(
        "shoulder",
        "revolute",
        one=arm,
        two=torso,
        origin=(4.0, 0.0, 10.0),
        axis=(0.0, 1.0, 0.0),
        limits=[(-1.0, 1.0)],
    )
    build.done()


def _page(root: Any, command: Any, tab: str, clicked: Sequence[Sequence[float]]) -> str:
    (item,) = (item for item in DEFINE.inputs if item.id == tab)
    shown = window(DEFINE, _example(command, item), item)
    return f"<!DOCTYPE html><style>{STYLE}</style>{_LAYOUT}{_view(root, clicked)}{shown}"


# The view of the design


def _view(root: Any, clicked: Sequence[Sequence[float]]) -> str:
    """Return the design with the custom graphics and the clicks, as SVG."""
    shapes = [*_triangles(root), *_graphics(root)]
    for place in clicked:
        x, y = _project(np.array(place))
        shapes.append(
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="9" fill="none" stroke="#ff7f0e" '
            'stroke-width="3"/>'
        )
    width, height = VIEW
    return (
        f'<svg width="{width}" height="{height}" style="background: #fff; border: 1px solid '
        f'#8c949d" font-family="Arial">{"".join(shapes)}</svg>'
    )


def _triangles(root: Any) -> list[str]:
    """Return the triangles of all bodies, the most distant one first."""
    faces = []
    for occurrence in root.allOccurrences:
        for body in occurrence.bRepBodies:
            calculator = body.meshManager.createMeshCalculator()
            mesh = calculator.calculate()
            nodes = np.reshape(mesh.nodeCoordinatesAsDouble, (-1, 3))
            for corners in nodes[np.reshape(mesh.nodeIndices, (-1, 3))]:
                normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
                if normal @ _FORWARD < 0.0:
                    faces.append((corners, normal / np.linalg.norm(normal), body.visibleOpacity))
    faces.sort(key=lambda item: -float(item[0].mean(axis=0) @ _FORWARD))
    return [_triangle(*item) for item in faces]


def _triangle(corners: np.ndarray, normal: np.ndarray, opacity: float) -> str:
    grey = round(165 + 70 * max(float(normal @ _LIGHT), 0.0))
    color = f"rgb({grey},{grey},{min(grey + 8, 255)})"
    places = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(_project, corners))
    return (
        f'<polygon points="{places}" fill="{color}" stroke="{color}" stroke-width="0.7" '
        f'opacity="{0.7 + 0.3 * opacity:.2f}"/>'
    )


def _graphics(root: Any) -> Iterator[str]:
    """Yield the lines and labels of the preview."""
    for group in root.customGraphicsGroups:
        for item in group:
            rgb = item.color.color
            color = f"rgb({rgb.red},{rgb.green},{rgb.blue})"
            if hasattr(item, "weight"):
                flat = np.reshape(item.coordinates.coordinates, (-1, 3))
                places = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(_project, flat))
                yield (
                    f'<polyline points="{places}" fill="none" stroke="{color}" '
                    f'stroke-width="{item.weight}" stroke-linejoin="round"/>'
                )
            else:
                x, y = _project(np.array(item.viewScale.anchorPoint.asArray()))
                yield (
                    f'<text x="{x + 6:.1f}" y="{y - 6:.1f}" fill="{color}" font-size="16" '
                    f'font-weight="600">{escape(item.formattedText)}</text>'
                )


def _project(place: np.ndarray) -> tuple[float, float]:
    """Return the pixel of a position in [cm]."""
    x, y = _RIGHT @ (place - _CENTRE), _UP @ (place - _CENTRE)
    return VIEW[0] / 2 + _SCALE * float(x), VIEW[1] / 2 - _SCALE * float(y)


# The dialog


def _example(command: Any, tab: Input) -> Example:
    """Return the contents of the inputs of a tab."""
    values, cells, choices = {}, {}, {}
    for item in (*tab.children, *(i for i in DEFINE.inputs if i.kind != "tab")):
        if item.kind == "table":
            rows = command.table(item.id)[1:]
            cells[item.id] = tuple(tuple(_text(cell) for cell in row) for row in rows)
            drops = [hasattr(command.cell(item.id, 1, j), "listItems") for j in range(len(rows[0]))]
            choices[item.id] = tuple(drops)
        elif item.kind in ("dropdown", "choices"):
            values[item.id] = ", ".join(command.chosen(item.id))
        elif item.kind == "text":
            values[item.id] = command[item.id].text.replace("<br/>", "\n")
        elif item.kind in ("string", "number", "check"):
            values[item.id] = command[item.id].value
        elif item.kind == "slider":
            values[item.id] = command[item.id].valueOne
    return Example(values, cells, choices, hidden=("properties",))


def _text(cell: Any) -> str:
    """Return the text of a cell; a coloured square is not coloured in the picture."""
    return "■ " + str(cell).partition("</font> ")[2] if "<font" in str(cell) else str(cell)


def main() -> None:
    """Write all pictures."""
    IMAGES.mkdir(parents=True, exist_ok=True)
    for step in steps():
        file = IMAGES / f"{step.name}.png"
        file.write_bytes(shot(step.page, (900, 700), 96, 6))
        print(file, file.stat().st_size, f"{step.clicks} clicks")


if __name__ == "__main__":
    main()
