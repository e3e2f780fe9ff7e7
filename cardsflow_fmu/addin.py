"""Installation and packaging of the Fusion add-in."""

from __future__ import annotations

import json
import os
import shutil
import sys
import uuid
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import addin_sdfusion
from addin_sdfusion.robot import InputError, limits
from addin_sdfusion.robot.files import read_file
from addin_sdfusion.robot.json_text import json_text

from .utils.archive import write_archive

BUNDLE = "addin_sdfusion.bundle"
NAME = "addin_sdfusion"
"""Name of the folder, the program and the manifest, which Fusion requires to be equal."""

ADD_INS = Path("Autodesk/Autodesk Fusion 360/API/AddIns")
"""Fusion's folder of add-ins, relative to the application data folder of the system."""

_ADD_INS_OF = {
    "windows": "%APPDATA%\\Autodesk\\Autodesk Fusion 360\\API\\AddIns",
    "mac": "~/Library/Application Support/Autodesk/Autodesk Fusion 360/API/AddIns",
}
"""Fusion's folder of add-ins on each system, as a user types it."""

_INSTALL = """\
CARDSFlow for Autodesk Fusion

1. Copy the folder {name} to
   {folder}
2. Start Fusion, press Shift+S, select {name} in Add-Ins, and press Run.
   The buttons are in Utilities > Add-Ins.
"""


def install(folder: str | Path | None = None) -> Path:
    """Copy the add-in into Fusion's folder of add-ins and replace an earlier copy.

    Args:
        folder: Fusion's folder of add-ins, or None for the folder of the current user.

    Raises:
        InputError: The folder does not exist, contains something else with this name, or cannot be
            written.
    """
    target = (_add_ins() if folder is None else Path(folder)) / NAME
    new, old = (target.with_name(f".{NAME}.{word}") for word in ("new", "old"))
    files = _files()
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        if old.exists() and not target.exists():
            old.rename(target)  # an earlier installation was interrupted
        _require_addin(target)
        for leftover in (new, old):
            if leftover.exists():
                shutil.rmtree(leftover)
        for path, source in files.items():
            (new / path).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, new / path)
        _replace_folder(target, new, old)
    except OSError as error:
        problem = f"cannot be written: {error.strerror or error}; is the add-in running in Fusion?"
        raise InputError(problem, file=target) from error
    finally:
        shutil.rmtree(new, ignore_errors=True)
    return target


def pack_addin(
    folder: str | Path, company: str = "", url: str = "", email: str = ""
) -> tuple[Path, ...]:
    """Pack the add-in: an archive for each system, and a bundle for Autodesk's App Store.

    The archives of a version are reproducible. The archive of a system contains the add-in's folder
    and INSTALL.txt.

    Args:
        folder: Folder of the archives; created if it does not exist.
        company: Name of the publisher; the author of the add-in if empty.
        url: Web page of the publisher; the store requires it.
        email: Email address of the publisher; the store requires it.
    """
    manifest = _manifest()
    files = {path: source.read_bytes() for path, source in _files().items()}
    stem = f"cardsflow-addin-{manifest['version']}"
    archives = []
    for system in manifest["supportedOS"].split("|"):
        system_manifest = json_text(manifest | {"supportedOS": system}, indent=4).encode()
        contents = {f"{NAME}/{path}": data for path, data in files.items()}
        contents[f"{NAME}/{NAME}.manifest"] = system_manifest
        contents["INSTALL.txt"] = _INSTALL.format(folder=_ADD_INS_OF[system], name=NAME).encode()
        archives.append(
            write_archive(Path(folder, f"{stem}-{system}.zip"), contents, compress=False)
        )
    contents = {f"{BUNDLE}/Contents/{path}": data for path, data in files.items()}
    described = _package_contents(manifest, company or manifest["author"], url, email)
    contents[f"{BUNDLE}/PackageContents.xml"] = described.encode()
    store = write_archive(Path(folder, f"{stem}-app-store.zip"), contents, compress=False)
    return (*archives, store)


def _manifest() -> dict[str, Any]:
    text = (Path(addin_sdfusion.__file__).parent / f"{NAME}.manifest").read_text("utf-8")
    manifest: dict[str, Any] = json.loads(text)
    return manifest


def _package_contents(manifest: Mapping[str, Any], company: str, url: str, email: str) -> str:
    """Return the store's XML description of the bundle, from the add-in's manifest."""
    version, upgrade = manifest["version"], uuid.UUID(manifest["id"])
    product = uuid.uuid5(upgrade, version)  # differs between versions
    attributes = {
        "SchemaVersion": "1.0",
        "AutodeskProduct": manifest["autodeskProduct"],
        "ProductType": "Application",
        "Name": manifest["author"],
        "Description": manifest["description"][""],
        "AppVersion": version,
        "Author": company,
        "ProductCode": f"{{{product}}}".upper(),
        "UpgradeCode": f"{{{upgrade}}}".upper(),
    }
    root = ElementTree.Element("ApplicationPackage", attributes)
    details = {"Name": company, "Url": url, "Email": email}
    ElementTree.SubElement(root, "CompanyDetails", details)
    parts = ElementTree.SubElement(root, "Components")
    systems = {"windows": "Win64", "mac": "Mac"}
    supported = "|".join(systems[name] for name in manifest["supportedOS"].split("|"))
    where = {"OS": supported, "Platform": manifest["autodeskProduct"]}
    ElementTree.SubElement(parts, "RuntimeRequirements", where)
    entry = {"AppName": NAME, "Version": version, "ModuleName": f"./Contents/{NAME}.py"}
    ElementTree.SubElement(parts, "ComponentEntry", entry | {"AppType": manifest["type"]})
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="utf-8"?>\n{text}\n'


def _files() -> dict[str, Path]:
    """Return the add-in's files by their paths relative to its folder, in order."""
    root = Path(addin_sdfusion.__file__).parent
    files = {path.relative_to(root).as_posix(): path for path in root.rglob("*") if path.is_file()}
    return {path: files[path] for path in sorted(files) if _is_source(Path(path))}


def _is_source(path: Path) -> bool:
    """Return whether a file belongs to the add-in, unlike caches and hidden files."""
    hidden = any(part.startswith(".") or part == "__pycache__" for part in path.parts)
    return not hidden and path.suffix not in (".pyc", ".pyo")


def _add_ins() -> Path:
    """Return Fusion's folder of add-ins for the current user."""
    system: str = sys.platform
    if system == "win32":
        base = Path(os.environ.get("APPDATA", Path.home() / "AppData/Roaming"))
    elif system == "darwin":
        base = Path.home() / "Library/Application Support"
    else:
        problem = (
            "Fusion does not support this system; specify Fusion's folder of add-ins with "
            "--folder, or pack the add-in with `cardsflow addin pack`"
        )
        raise InputError(problem)
    folder = base / ADD_INS
    if not folder.is_dir():
        problem = "does not exist; start Fusion once, or specify its folder of add-ins"
        raise InputError(f"{problem} with --folder", file=folder)
    return folder


def _require_addin(target: Path) -> None:
    """Reject a target that is not an earlier installation."""
    if target.is_symlink():
        problem = "is a link, whose target Fusion already runs; remove the link to install a copy"
        raise InputError(problem, file=target)
    if not target.exists():
        return
    identity = _identity(Path(addin_sdfusion.__file__).parent)
    if not target.is_dir() or identity is None or _identity(target) != identity:
        raise InputError("is not this add-in; move it, or use another --folder", file=target)


def _identity(folder: Path) -> str | None:
    """Return the id in an add-in's manifest, or None without a valid manifest."""
    try:
        plain = json.loads(read_file(folder / f"{NAME}.manifest", limits.JSON).decode("utf-8-sig"))
    except (InputError, ValueError, RecursionError):
        return None
    return str(plain["id"]) if isinstance(plain, dict) and plain.get("id") else None


def _replace_folder(target: Path, new: Path, old: Path) -> None:
    """Replace a folder by a new one; after an error the old folder is restored."""
    if target.exists():
        target.rename(old)
    try:
        new.rename(target)
    except OSError:
        if old.exists():
            old.rename(target)
        raise
    shutil.rmtree(old, ignore_errors=True)
