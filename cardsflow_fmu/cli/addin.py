"""`cardsflow import-cad` and `addin`: designs of CAD systems, and the add-in for Fusion."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from addin_sdfusion.robot import InputError, RobotError

from .common import (
    FAILED,
    GOOD,
    add_json,
    add_output,
    add_settings,
    parse_settings,
    print_files,
    print_findings,
)
from .parser import Commands
from .terminal.progress import show_progress


def add_import_cad(commands: Commands) -> None:
    """Add `import-cad`."""
    parser = commands.add(
        "import-cad",
        _import_cad,
        "Create the folder of a robot from a CAD design.",
        "cardsflow import-cad examples/from_cad/two_link_arm.json -o arm",
        "The design is a snapshot (.json), a Python program that uses build123d (.py; it is "
        "executed), or a STEP file with tables of its joints and muscles.",
    )
    parser.add_argument("design", type=Path, help="a snapshot, .py, .step or .stp")
    _add_export(parser)
    step = parser.add_argument_group("options for STEP files")
    for name, what in (
        ("joints", "table of the joints between the parts"),
        ("muscles", "table of the muscles and task points"),
        ("wraps", "table of the faces that muscles wrap around"),
        ("materials", "table of densities or masses of parts"),
    ):
        text = f"{what} (default: none)"
        step.add_argument(f"--{name}", type=Path, metavar="CSV", help=text)
    step.add_argument(
        "--density",
        type=float,
        metavar="X",
        help="density of parts without a material, in kg/m3 (default: none)",
    )
    step.add_argument(
        "--time-limit",
        type=float,
        metavar="S",
        help="largest time to read the file, in s (default: 600)",
    )


def add_addin(commands: Commands) -> None:
    """Add `addin` and its actions."""
    text = "Install or pack the add-in for Fusion; export its snapshots."
    actions = commands.group("addin", text, "cardsflow addin install")
    parser = actions.add(
        "export-snapshot",
        _import_cad,
        "Export a robot from a snapshot, as the add-in does inside Fusion.",
        "cardsflow addin export-snapshot arm.json -o arm --set collision=none",
        "It does the same as `cardsflow import-cad`.",
    )
    parser.add_argument("design", type=Path, help="the JSON file that the add-in saved")
    _add_export(parser)
    parser = actions.add(
        "install",
        _install_addin,
        "Copy the add-in into Fusion's folder of add-ins; replace an earlier copy.",
        "cardsflow addin install",
    )
    parser.add_argument(
        "--folder",
        type=Path,
        help="folder of Fusion's add-ins (default: the standard folder of this system)",
    )
    add_json(parser, "the folder name")
    parser = actions.add(
        "pack",
        _pack_addin,
        "Pack the add-in as a bundle for Autodesk's App Store.",
        "cardsflow addin pack -o bundle.zip --company Us --url https://example.org "
        "--email us@example.org",
    )
    add_output(parser, "the archive to write", required=True)
    for name, text in (
        ("company", "the publisher"),
        ("url", "web page of the publisher"),
        ("email", "e-mail address for the store"),
    ):
        parser.add_argument(f"--{name}", required=True, help=f"{text} (required)")
    add_json(parser, "the file name")
    parser = actions.add(
        "zip",
        _zip_addin,
        "Pack the folder of the add-in, to be unpacked into Fusion's folder of add-ins.",
        "cardsflow addin zip -o addin_sdfusion.zip",
    )
    add_output(parser, "the archive to write", required=True)
    add_json(parser, "the file name")


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
    what = "folder for the robot; files that you edited stay (default: the name of the design)"
    add_output(parser, what, metavar="FOLDER")
    add_settings(parser, "setting of the export", "up_axis=y")
    add_json(parser, "files and findings")


def _import_cad(options: argparse.Namespace) -> int:
    from cardsflow_fmu.cad import Tables, import_cad

    given = {
        name: value
        for name in ("joints", "muscles", "wraps", "materials", "density")
        if (value := getattr(options, name, None)) is not None
    }
    if not 0.0 < given.get("density", 1.0) < math.inf:
        what = f"must be positive and finite, not {options.density:g}"
        raise InputError(what, key="--density")
    limit = getattr(options, "time_limit", None)
    if limit is not None and not 0.0 < limit < math.inf:
        raise InputError(f"must be positive and finite, not {limit:g}", key="--time-limit")
    time = {} if limit is None else {"time_limit": limit}
    folder = options.output or Path(options.design.stem)
    tables = Tables(**given) if given else None
    try:
        with show_progress("import-cad"):
            exported = import_cad(
                options.design, folder, parse_settings(options.set), tables, **time
            )
        findings, files = exported.findings, exported.files
    except RobotError as error:
        findings, files = error.findings, ()
    if not options.json:
        print_findings(findings, verbose=True)
    print_files(files, options.json, findings=[finding.as_dict() for finding in findings])
    return FAILED if any(finding.is_error for finding in findings) else GOOD
