"""The command line `cardsflow`: parsing, exit codes, error messages."""

from __future__ import annotations

import time

_STARTED = time.perf_counter()

import argparse  # noqa: E402
import sys  # noqa: E402
import traceback  # noqa: E402
from collections.abc import Sequence  # noqa: E402

from addin_sdfusion.robot import CardsflowError, InputError  # noqa: E402
from addin_sdfusion.robot.files import file_error  # noqa: E402
from cardsflow_fmu.utils import interrupts  # noqa: E402
from cardsflow_fmu.version import __version__  # noqa: E402

from .addin import add_addin, add_import_cad  # noqa: E402
from .calibrate import add_calibrate, add_excite  # noqa: E402
from .common import EXIT_CODES, FAILED, INTERRUPTED  # noqa: E402
from .device import add_device, add_replay  # noqa: E402
from .examples import add_examples  # noqa: E402
from .init import add_completion, add_init, add_schema  # noqa: E402
from .parser import BAD_INPUT, Commands, Parser  # noqa: E402
from .results import add_compare, add_plot, add_report  # noqa: E402
from .robot import add_activations, add_check, add_convert, add_info, add_size  # noqa: E402
from .run import add_build, add_run  # noqa: E402
from .study import add_study  # noqa: E402
from .terminal.messages import print_error, quiet_messages  # noqa: E402
from .terminal.streams import discard_output, printable_streams  # noqa: E402
from .terminal.suggestions import suggest_file  # noqa: E402
from .view import add_view  # noqa: E402

_COMMANDS = {
    "Start": (add_init, add_examples, add_check, add_info),
    "Simulate": (add_run, add_build, add_view, add_report, add_plot, add_compare),
    "Analyse and design": (add_size, add_activations, add_study),
    "Hardware": (add_device, add_replay, add_excite, add_calibrate),
    "CAD and files": (add_import_cad, add_convert, add_addin),
    "Shell and editor": (add_schema, add_completion),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command.

    Args:
        arguments: Words after `cardsflow` (default: arguments of the process).

    Returns:
        The exit code; see `EXIT_CODES`.
    """
    with printable_streams():
        try:
            with interrupts.raise_on_termination() as received:
                given = argparse.Namespace(started=_STARTED)
                return _run(_parse(arguments, given), received)
        except KeyboardInterrupt:
            print_error(interrupts.INTERRUPTED)
            return INTERRUPTED


def _parse(arguments: Sequence[str] | None, given: argparse.Namespace) -> argparse.Namespace:
    """Parse the options; raise SystemExit after `--help`, `--version` and usage errors."""
    try:
        return _parser().parse_args(arguments, given)
    except SystemExit:
        if not _flush_output():
            raise SystemExit(FAILED) from None
        raise


def _run(options: argparse.Namespace, received: Sequence[int]) -> int:
    try:
        with quiet_messages(options.quiet):
            code = int(options.command(options))
        return code if _flush_output() else FAILED
    except Exception as error:
        if options.debug:
            traceback.print_exc()
        if received and not _is_interruption(error):
            raise KeyboardInterrupt from None
        if isinstance(error, OSError):
            place = "" if error.filename is None else f"{error.filename}: "
            print_error(f"{place}{error.strerror or error}")
            _flush_output()
            return _code_of(file_error(error, "", place)) if place else FAILED
        if isinstance(error, CardsflowError):
            print_error(f"{error}{suggest_file(error)}")
            return _code_of(error)
        what = f"{type(error).__name__}: {error}"
        print_error(f"internal error: {what} (--debug prints the traceback)")
        return FAILED


def _flush_output() -> bool:
    """Flush stdout; return false if this fails, for example because the disk is full."""
    try:
        sys.stdout.flush()
        return True
    except OSError as error:
        print_error(f"{error.filename}: {error.strerror}")
        discard_output(sys.stdout)
        return False


def _code_of(error: CardsflowError) -> int:
    if isinstance(error, InputError):
        return BAD_INPUT
    return INTERRUPTED if _is_interruption(error) else FAILED


def _is_interruption(error: Exception) -> bool:
    return str(error).partition(";")[0] == interrupts.INTERRUPTED


def _parser() -> Parser:
    parser = Parser(
        prog="cardsflow",
        description="Simulate and control musculoskeletal (cable-driven) robots; build their FMUs.",
        epilog="example:\n  cardsflow run examples/planar_2r -o results\n\n"
        f"`cardsflow COMMAND --help` lists the options of a command.\n\n{EXIT_CODES}",
    )
    parser.set_defaults(parser=parser)
    parser.add_argument("--version", action="version", version=f"cardsflow {__version__}")
    commands = Commands(parser, "COMMAND")
    for title, group in _COMMANDS.items():
        commands.start_group(title)
        for add in group:
            add(commands)
    return parser


if __name__ == "__main__":
    sys.exit(main())
