"""`cardsflow addin`: the commands about the Fusion add-in."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import RobotError

from .common import FAILED, GOOD, add_command, add_json, print_files, settings_of


def add_addin(commands: Any, common: argparse.ArgumentParser) -> None:
    """Add `addin` and its actions."""
    text = "The add-in for Fusion: export without Fusion, install it, pack it."
    group = commands.add_parser(
        "addin",
        help=text,
        description=text,
        epilog="example:\n  cardsflow addin install",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    actions = group.add_subparsers(metavar="ACTION", required=True)
    parser = add_command(
        actions,
        common,
        "export-snapshot",
        "Export a design from its snapshot, as the add-in does inside Fusion.",
        "cardsflow addin export-snapshot arm.json -o arm --set collision=none",
    )
    parser.add_argument("snapshot", type=Path, help="the JSON file that the add-in has saved")
    parser.add_argument("-o", "--output", type=Path, required=True, help="the robot's folder")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="change a setting of the export, such as up_axis=y; may be repeated",
    )
    add_json(parser, "files and findings")
    parser.set_defaults(command=_export_snapshot)
    parser = add_command(
        actions,
        common,
        "install",
        "Copy the add-in to where Fusion looks for it, in place of an earlier copy.",
        "cardsflow addin install",
    )
    parser.add_argument("--folder", type=Path, help="Fusion's folder of add-ins, if it is another")
    add_json(parser, "the folder")
    parser.set_defaults(command=_install_addin)
    parser = add_command(
        actions,
        common,
        "zip",
        "Pack the add-in's folder, to be unpacked among Fusion's add-ins.",
        "cardsflow addin zip -o addin_sdfusion.zip",
    )
    parser.add_argument("-o", "--output", type=Path, required=True, help="the archive")
    add_json(parser, "the file")
    parser.set_defaults(command=_zip_addin)


def _export_snapshot(options: argparse.Namespace) -> int:
    from cardsflow_fmu.addin import export_snapshot

    try:
        exported = export_snapshot(options.snapshot, options.output, settings_of(options.set))
        findings, files = exported.findings, exported.files
    except RobotError as error:
        findings, files = error.findings, ()
    if not options.json:
        for finding in findings:
            print(finding, file=sys.stderr)
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
