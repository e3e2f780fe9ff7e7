"""Draws the icons of the add-in's commands: `python docs/make_addin_icons.py`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PIL import Image, ImageDraw

COMMANDS = Path(__file__).parents[1] / "addin_sdfusion" / "commands"
SIZES = {
    "16x16": 16,
    "16x16@2x": 32,
    "32x32": 32,
    "32x32@2x": 64,
    "64x64": 64,
}
SAMPLES = 16  # along each side of a pixel

Color = tuple[int, int, int]
Shape = Callable[[ImageDraw.ImageDraw, Color, int], None]
"""Function that draws a shape in a color on a square with a width in pixels."""
Layer = tuple[Color, Shape]
RED, BLUE, GREY, WHITE, GREEN, AMBER = (
    (224, 64, 64),
    (56, 132, 206),
    (122, 132, 144),
    (250, 250, 250),
    (46, 140, 70),
    (226, 152, 20),
)
"""Red, blue and grey, which are visible on light and dark toolbars."""


def line(*points: tuple[float, float], width: float) -> Shape:
    """Return the shape of a line with round ends; coordinates are 0 to 1, y downwards."""

    def draw(canvas: ImageDraw.ImageDraw, color: Color, size: int) -> None:
        ends = [(size * x, size * y) for x, y in points]
        canvas.line(ends, color, round(width * size))
        for end in ends:
            canvas.circle(end, width * size / 2, color)

    return draw


def disc(x: float, y: float, radius: float) -> Shape:
    """Return the shape of a filled circle."""
    return lambda canvas, color, size: canvas.circle((size * x, size * y), size * radius, color)


def polygon(*corners: tuple[float, float]) -> Shape:
    """Return the shape of a filled polygon."""
    return lambda canvas, color, size: canvas.polygon(
        [(size * x, size * y) for x, y in corners], color
    )


def box(x0: float, y0: float, x1: float, y1: float) -> Shape:
    """Return the shape of a filled rectangle."""
    return polygon((x0, y0), (x1, y0), (x1, y1), (x0, y1))


ICONS: dict[str, list[Layer]] = {
    "define_muscles": [
        (GREY, line((0.16, 0.88), (0.16, 0.3), width=0.16)),
        (GREY, line((0.16, 0.88), (0.86, 0.88), width=0.16)),
        (RED, line((0.16, 0.14), (0.52, 0.34), (0.84, 0.74), width=0.1)),
        (RED, disc(0.16, 0.14, 0.13)),
        (RED, disc(0.54, 0.36, 0.13)),
        (RED, disc(0.84, 0.74, 0.13)),
    ],
    "check": [
        (GREY, box(0.08, 0.06, 0.92, 0.94)),
        (WHITE, box(0.16, 0.14, 0.84, 0.86)),
        (GREEN, line((0.28, 0.52), (0.44, 0.7), (0.74, 0.28), width=0.13)),
    ],
    "export": [
        (GREY, line((0.12, 0.56), (0.12, 0.88), (0.88, 0.88), (0.88, 0.56), width=0.13)),
        (BLUE, line((0.5, 0.66), (0.5, 0.16), width=0.14)),
        (BLUE, line((0.26, 0.38), (0.5, 0.14), (0.74, 0.38), width=0.14)),
    ],
}


SEVERITIES: dict[str, list[Layer]] = {
    "error": [
        (RED, disc(0.5, 0.5, 0.44)),
        (WHITE, line((0.32, 0.32), (0.68, 0.68), width=0.13)),
        (WHITE, line((0.68, 0.32), (0.32, 0.68), width=0.13)),
    ],
    "warning": [
        (AMBER, polygon((0.5, 0.06), (0.96, 0.9), (0.04, 0.9))),
        (WHITE, line((0.5, 0.36), (0.5, 0.6), width=0.12)),
        (WHITE, disc(0.5, 0.77, 0.07)),
    ],
}
"""Icons of the buttons in the rows of Check."""


def icon(layers: list[Layer], size: int, *, faint: bool = False) -> Image.Image:
    """Return an icon with smooth edges."""
    width = SAMPLES * size
    large = Image.new("RGBA", (width, width))
    for color, draw in layers:
        draw(ImageDraw.Draw(large), color, width)
    image = large.resize((size, size), Image.Resampling.BOX)
    if faint:
        grey, opacity = image.convert("LA").split()
        image = Image.merge("LA", (grey, opacity.point(lambda value: 0.4 * value))).convert("RGBA")
    return image


def main() -> None:
    """Write all icons."""
    for command, layers in ICONS.items():
        write(layers, COMMANDS / command / "resources")
    for severity, layers in SEVERITIES.items():
        write(layers, COMMANDS / "check" / "resources" / "severity" / severity)


def write(layers: list[Layer], folder: Path) -> None:
    """Write an icon in all sizes."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, size in SIZES.items():
        plain, _, scale = name.partition("@")
        scale = f"@{scale}" if scale else ""
        icon(layers, size).save(folder / f"{name}.png", optimize=True)
        icon(layers, size, faint=True).save(folder / f"{plain}-disabled{scale}.png", optimize=True)


if __name__ == "__main__":
    main()
