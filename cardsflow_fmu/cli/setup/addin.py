"""`cardsflow import-cad` and `addin`: designs of CAD systems, and the add-in for Fusion."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from addin_sdfusion.exporting.export import requested_findings
from addin_sdfusion.robot import Finding, InputError, RobotError
from addin_sdfusion.settings import ExportSettings
from cardsflow_fmu.cli.common import (
    FAILED,
    GOOD,
    add_json,
    add_output,
    add_settings,
    parse_settings,
    print_files,
    print_findings,
)
from cardsflow_fmu.cli.parser import Commands
from cardsflow_fmu.cli.terminal.messages import print_warning
from cardsflow_fmu.cli.terminal.progress import show_progress

from .init import print_test_run, report_failed_test_run

if TYPE_CHECKING:
    from cardsflow_fmu.cad import Imported


def add_import_cad(commands: Commands) -> None:
    """Add `import-cad`."""
    parser = commands.add(
        "import-cad",
        _import_cad,
        "Create the folder of a robot from a CAD design.",
        "cardsflow import-cad examples/from_cad/two_link_arm.json -o arm",
        "The design is a snapshot that the add-in saved (.json), a Python program that uses "
        "build123d (.py; it is executed), or a STEP file with tables of its joints and muscles.",
    )
    parser.add_argument("design", type=Path, help="a snapshot, .py, .step or .stp")
    text = "folder for the robot; files that you edited stay (default: the name of the design)"
    add_output(parser, text, metavar="FOLDER")
    add_settings(parser, "setting of the export", "up_axis=y")
    add_json(parser, "files and findings")
    step = parser.add_argument_group("options for STEP files")
    for name, meaning in (
        ("joints", "table of the joints between the parts"),
        ("muscles", "table of the muscles and task points"),
        ("wraps", "table of the faces that muscles wrap around"),
        ("materials", "table of densities or masses of parts"),
    ):
        text = f"{meaning} (default: none)"
        step.add_argument(f"--{name}", type=Path, metavar="CSV", help=text)
    text = "density of parts without a material, in kg/m3 (default: none)"
    step.add_argument("--density", type=float, metavar="X", help=text)
    text = "largest time to read the file, in s (default: 600)"
    step.add_argument("--time-limit", type=float, metavar="S", help=text)


def add_addin(commands: Commands) -> None:
    """Add `addin` and its actions."""
    text = "Install or pack the add-in for Fusion."
    actions = commands.group("addin", text, "cardsflow addin install")
    parser = actions.add(
        "install",
        _install_addin,
        "Copy the add-in into Fusion's folder of add-ins; replace an earlier copy.",
        "cardsflow addin install",
    )
    text = "folder of Fusion's add-ins (default: the standard folder of this system)"
    parser.add_argument("--folder", type=Path, help=text)
    add_json(parser, "the folder name")
    parser = actions.add(
        "pack",
        _pack_addin,
        "Pack the add-in: an archive for each system, and a bundle for Autodesk's App Store.",
        "cardsflow addin pack -o packed",
    )
    add_output(parser, "folder of the archives (default: the current folder)", metavar="FOLDER")
    for name, text in (
        ("company", "the publisher in the bundle (default: the author of the add-in)"),
        ("url", "web page of the publisher, which the store requires (default: none)"),
        ("email", "e-mail address for the store, which requires it (default: none)"),
    ):
        parser.add_argument(f"--{name}", default="", help=text)
    add_json(parser, "the file names")


def _pack_addin(options: argparse.Namespace) -> int:
    from cardsflow_fmu.addin import pack_addin

    publisher = {name: getattr(options, name).strip() for name in ("company", "url", "email")}
    missing = [f"--{name}" for name in ("url", "email") if not publisher[name]]
    notes = []
    if missing:
        notes.append(f"the store rejects the bundle without {' and '.join(missing)}")
    files = pack_addin(options.output or Path(), **publisher)
    if not options.json:
        for note in notes:
            print_warning(note)
    print_files(files, options.json, notes=notes)
    return GOOD


def _install_addin(options: argparse.Namespace) -> int:
    from cardsflow_fmu.addin import install

    print_files([install(options.folder)], options.json)
    return GOOD


def _import_cad(options: argparse.Namespace) -> int:
    from cardsflow_fmu.cad import Imported, Tables, import_cad

    tables_given = {
        name: value
        for name in ("joints", "muscles", "wraps", "materials", "density")
        if (value := getattr(options, name, None)) is not None
    }
    if not 0.0 < tables_given.get("density", 1.0) < math.inf:
        problem = f"must be positive and finite, not {options.density:g}"
        raise InputError(problem, key="--density")
    limit = getattr(options, "time_limit", None)
    if limit is not None and not 0.0 < limit < math.inf:
        raise InputError(f"must be positive and finite, not {limit:g}", key="--time-limit")
    time = {} if limit is None else {"time_limit": limit}
    folder = options.output or Path(options.design.stem)
    tables = Tables(**tables_given) if tables_given else None
    settings = parse_settings(options.set)
    try:
        with show_progress("import-cad"):
            imported = import_cad(options.design, folder, settings, tables, **time)
    except RobotError as error:
        imported = Imported((), error.findings, {})
    findings, notes = _requested_findings(imported, settings, folder)
    code = report_failed_test_run(imported.test_run)
    if not options.json:
        print_findings(findings, verbose=True)
        for note in notes:
            print_warning(note)
    listed = [finding.as_dict() for finding in findings]
    print_files(imported.files, options.json, notes=notes, findings=listed)
    if not options.json:
        print_test_run(imported.test_run)
    return FAILED if any(finding.is_error for finding in findings) else code


def _requested_findings(
    imported: Imported, settings: Mapping[str, Any], folder: Path
) -> tuple[list[Finding], list[str]]:
    """Return the findings to print, and the notes.

    Losses of a format that is written by default are counted in a note, unless `--set` requests
    the format.
    """
    defaults = ExportSettings()
    asked = [n for n in imported.losses if not getattr(defaults, n) or n in settings]
    findings, note = requested_findings(imported.findings, imported.losses, asked, folder)
    return findings, [*imported.notes, *([note] if note else [])]
