"""`cardsflow addin`: the commands about the Fusion add-in."""

from __future__ import annotations

import argparse
from pathlib import Path

from addin_sdfusion.robot import RobotError

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


def add_addin(commands: Commands) -> None:
    """Add `addin` and its actions."""
    text = "The add-in for Fusion: export without Fusion, install it, pack it."
    actions = commands.group("addin", text, "cardsflow addin install")
    parser = actions.add(
        "export-snapshot",
        _export_snapshot,
        "Export a design from its snapshot, as the add-in does inside Fusion.",
        "cardsflow addin export-snapshot arm.json -o arm --set collision=none",
    )
    parser.add_argument("snapshot", type=Path, help="the JSON file that the add-in has saved")
    add_output(parser, "the robot's folder", required=True)
    add_settings(parser, "setting of the export", "up_axis=y")
    add_json(parser, "files and findings")
    parser = actions.add(
        "install",
        _install_addin,
        "Copy the add-in to where Fusion looks for it, in place of an earlier copy.",
        "cardsflow addin install",
    )
    parser.add_argument("--folder", type=Path, help="Fusion's folder of add-ins, if it is another")
    add_json(parser, "the folder")
    parser = actions.add(
        "zip",
        _zip_addin,
        "Pack the add-in's folder, to be unpacked among Fusion's add-ins.",
        "cardsflow addin zip -o addin_sdfusion.zip",
    )
    add_output(parser, "the archive", required=True)
    add_json(parser, "the file")


def _export_snapshot(options: argparse.Namespace) -> int:
    from cardsflow_fmu.addin import export_snapshot

    try:
        exported = export_snapshot(options.snapshot, options.output, settings_of(options.set))
        findings, files = exported.findings, exported.files
    except RobotError as error:
        findings, files = error.findings, ()
    if not options.json:
        print_findings(findings, verbose=True)
    print_files(files, options.json, findings=[finding.as_dict() for finding in findings])
    return FAILED if any(finding.is_error for finding in findings) else GOOD


def _install_addin(options: argparse.Namespace) -> int:
    from cardsflow_fmu.addin import install

    print_files([install(options.folder)], options.json)
    return GOOD


def _zip_addin(options: argparse.Namespace) -> int:
    from cardsflow_fmu.addin import zip_addin

    print_files([zip_addin(options.output)], options.json)
    return GOOD
