"""`cardsflow import-cad`, and `addin`: designs of CAD systems, and the add-in for Fusion."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from addin_sdfusion.robot import InputError, RobotError

from .common import (
    FAILED,
    GOOD,
    Commands,
    add_json,
    add_output,
    add_settings,
    print_files,
    print_findings,
    settings_of,
)


def add_import_cad(commands: Commands) -> None:
    """Add `import-cad`."""
    parser = commands.add(
        "import-cad",
        _import_cad,
        "Make a robot's folder of a CAD design: a snapshot (.json), a program that draws with "
        "build123d (.py; it is run), or a STEP file with tables of its joints and muscles.",
        "cardsflow import-cad examples/from_cad/two_link_arm.json arm",
    )
    parser.add_argument("design", type=Path, help="a snapshot, .py, .step or .stp")
    parser.add_argument(
        "folder", type=Path, nargs="?", help="the robot's folder; the design's name when left out"
    )
    step = parser.add_argument_group("of a STEP file")
    step.add_argument("--joints", type=Path, metavar="CSV", help="the joints between its parts")
    step.add_argument("--muscles", type=Path, metavar="CSV", help="its muscles and task points")
    step.add_argument("--wraps", type=Path, metavar="CSV", help="the faces that muscles wrap over")
    step.add_argument("--materials", type=Path, metavar="CSV", help="densities or masses of parts")
    step.add_argument("--density", type=float, help="of all other parts, in kg/m3")
    step.add_argument(
        "--time-limit", type=float, metavar="S", help="how long reading it may take, in s; 600"
    )
    _add_export(parser)


def add_addin(commands: Commands) -> None:
    """Add `addin` and its actions."""
    text = "The add-in for Fusion: export without Fusion, install it, pack it."
    actions = commands.group("addin", text, "cardsflow addin install")
    parser = actions.add(
        "export-snapshot",
        _import_cad,
        "Export a design from its snapshot, as the add-in does inside Fusion: the same as "
        "`cardsflow import-cad`.",
        "cardsflow addin export-snapshot arm.json -o arm --set collision=none",
    )
    parser.add_argument("design", type=Path, help="the JSON file that the add-in has saved")
    parser.add_argument(
        "-o", "--output", dest="folder", type=Path, required=True, help="the robot's folder"
    )
    _add_export(parser)
    parser = actions.add(
        "install",
        _install_addin,
        "Copy the add-in to where Fusion looks for it, in place of an earlier copy.",
        "cardsflow addin install",
    )
    parser.add_argument("--folder", type=Path, help="Fusion's folder of add-ins, if it is another")
    add_json(parser, "the folder")
    parser = actions.add(
        "pack",
        _pack_addin,
        "Pack the add-in as a bundle for Autodesk's App Store.",
        "cardsflow addin pack -o bundle.zip --company Us --url https://example.org "
        "--email us@example.org",
    )
    add_output(parser, "the archive", required=True)
    for name, text in (
        ("company", "who publishes it"),
        ("url", "their page"),
        ("email", "whom the store writes to"),
    ):
        parser.add_argument(f"--{name}", required=True, help=text)
    add_json(parser, "the file")
    parser = actions.add(
        "zip",
        _zip_addin,
        "Pack the add-in's folder, to be unpacked among Fusion's add-ins.",
        "cardsflow addin zip -o addin_sdfusion.zip",
    )
    add_output(parser, "the archive", required=True)
    add_json(parser, "the file")


def _pack_addin(options: argparse.Namespace) -> int:
    from cardsflow_fmu.addin import pack_addin

    file = pack_addin(options.output, options.company, options.url, options.email)
    print_files([file], options.json)
    return GOOD


def _install_addin(options: argparse.Namespace) -> int:
    from cardsflow_fmu.addin import install

    print_files([install(options.folder)], options.json)
    return GOOD


def _zip_addin(options: argparse.Namespace) -> int:
    from cardsflow_fmu.addin import zip_addin

    print_files([zip_addin(options.output)], options.json)
    return GOOD


def _add_export(parser: argparse.ArgumentParser) -> None:
    """Add the options of every export."""
    add_settings(parser, "setting of the export", "up_axis=y")
    add_json(parser, "files and findings")


def _import_cad(options: argparse.Namespace) -> int:
    """Import a design."""
    from cardsflow_fmu.cad import Tables, import_cad

    given = {
        name: value
        for name in ("joints", "muscles", "wraps", "materials", "density")
        if (value := getattr(options, name, None)) is not None
    }
    if not 0.0 < given.get("density", 1.0) < math.inf:
        raise InputError(f"must be greater than 0, not {options.density:g}", key="--density")
    limit = getattr(options, "time_limit", None)
    if limit is not None and not 0.0 < limit < math.inf:
        raise InputError(f"must be greater than 0, not {limit:g}", key="--time-limit")
    time = {} if limit is None else {"time_limit": limit}
    folder = options.folder or Path(options.design.stem)
    tables = Tables(**given) if given else None
    try:
        exported = import_cad(options.design, folder, settings_of(options.set), tables, **time)
        findings, files = exported.findings, exported.files
    except RobotError as error:
        findings, files = error.findings, ()
    if not options.json:
        print_findings(findings, verbose=True)
    print_files(files, options.json, findings=[finding.as_dict() for finding in findings])
    return FAILED if any(finding.is_error for finding in findings) else GOOD
