"""Draws the icons of the add-in's commands: `python docs/make_addin_icons.py`."""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

COMMANDS = Path(__file__).parents[1] / "addin_sdfusion" / "commands"
SIZES = {
    "16x16": 16,
    "16x16@2x": 32,
    "32x32": 32,
    "32x32@2x": 64,
    "64x64": 64,
}
SAMPLES = 4  # along each side of a pixel

Color = tuple[int, int, int]
Layer = tuple[Color, Callable[[float, float], bool]]
RED, BLUE, GREY, WHITE, GREEN, AMBER = (
    (224, 64, 64),
    (56, 132, 206),
    (122, 132, 144),
    (250, 250, 250),
    (46, 140, 70),
    (226, 152, 20),
)
"""Red, blue and grey, which are visible on light and dark toolbars."""


def line(*points: tuple[float, float], width: float) -> Callable[[float, float], bool]:
    """Return the shape of a line with round ends; coordinates are 0 to 1, y downwards."""

    def inside(x: float, y: float) -> bool:
        return any(distance(x, y, a, b) <= width / 2 for a, b in pairwise(points))

    return inside


def distance(x: float, y: float, a: tuple[float, float], b: tuple[float, float]) -> float:
    """Return the distance of a point from the line segment between two others."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    t = ((x - a[0]) * dx + (y - a[1]) * dy) / (dx * dx + dy * dy)
    t = min(max(t, 0.0), 1.0)
    return math.hypot(x - a[0] - t * dx, y - a[1] - t * dy)


def disc(x0: float, y0: float, radius: float) -> Callable[[float, float], bool]:
    """Return the shape of a filled circle."""
    return lambda x, y: math.hypot(x - x0, y - y0) <= radius


def box(x0: float, y0: float, x1: float, y1: float) -> Callable[[float, float], bool]:
    """Return the shape of a filled rectangle."""
    return lambda x, y: x0 <= x <= x1 and y0 <= y <= y1


def triangle(*corners: tuple[float, float]) -> Callable[[float, float], bool]:
    """Return the shape of a filled triangle with clockwise corners."""

    def inside(x: float, y: float) -> bool:
        ends = zip(corners, (*corners[1:], corners[0]), strict=True)
        return all((c - a) * (y - b) - (d - b) * (x - a) >= 0.0 for (a, b), (c, d) in ends)

    return inside


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
        (AMBER, triangle((0.5, 0.06), (0.96, 0.9), (0.04, 0.9))),
        (WHITE, line((0.5, 0.36), (0.5, 0.6), width=0.12)),
        (WHITE, disc(0.5, 0.77, 0.07)),
    ],
}
"""Icons of the buttons in the rows of Check."""


def pixels(layers: list[Layer], size: int, faint: bool = False) -> bytes:
    """Return the bytes of an icon: each row after the filter byte of PNG."""
    rows = bytearray()
    for row in range(size):
        rows.append(0)
        for column in range(size):
            rows += pixel(layers, column / size, row / size, 1 / size, faint)
    return bytes(rows)


def pixel(layers: list[Layer], x: float, y: float, width: float, faint: bool) -> bytes:
    """Return red, green, blue and opacity of a square as the mean over its samples."""
    sums, covered = [0, 0, 0], 0
    for i in range(SAMPLES * SAMPLES):
        u = x + width * (i % SAMPLES + 0.5) / SAMPLES
        v = y + width * (i // SAMPLES + 0.5) / SAMPLES
        colors = [color for color, inside in layers if inside(u, v)]
        if colors:
            covered += 1
            sums = [s + c for s, c in zip(sums, colors[-1], strict=True)]
    if not covered:
        return bytes(4)
    color = [round(s / covered) for s in sums]
    if faint:
        color = [round(sum(color) / 3)] * 3
    opacity = round(255 * covered / SAMPLES**2 * (0.4 if faint else 1.0))
    return bytes([*color, opacity])


def png(data: bytes, size: int) -> bytes:
    """Return pixels as a PNG file."""

    def chunk(kind: bytes, content: bytes) -> bytes:
        crc = zlib.crc32(kind + content)
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", crc)

    header = struct.pack(">IIBBBBB", size, size, 8, 6, 0, 0, 0)
    parts = (chunk(b"IHDR", header), chunk(b"IDAT", zlib.compress(data, 9)), chunk(b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


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
        (folder / f"{name}.png").write_bytes(png(pixels(layers, size), size))
        faint = png(pixels(layers, size, faint=True), size)
        scale = f"@{scale}" if scale else ""
        (folder / f"{plain}-disabled{scale}.png").write_bytes(faint)


if __name__ == "__main__":
    main()
