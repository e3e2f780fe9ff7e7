"""Icons in resource folders."""

from __future__ import annotations

from pathlib import Path


def check_icons(folder: str) -> None:
    """Check that a resource folder contains icons of both sizes, as PNG or SVG."""
    if not folder:
        return
    for size in ("16x16", "32x32"):
        if not any((Path(folder) / f"{size}.{kind}").is_file() for kind in ("png", "svg")):
            raise RuntimeError(f"3 : invalid argument resourceFolder: no {size} icon in {folder}")
