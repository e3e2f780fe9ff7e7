"""The command line `cardsflow`: parsing, exit codes, messages of errors."""

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
from .common import BAD_INPUT, EXIT_CODES, FAILED, INTERRUPTED, Commands  # noqa: E402
from .device import add_device, add_replay  # noqa: E402
from .init import add_completion, add_init, add_schema  # noqa: E402
from .results import add_compare, add_plot, add_report  # noqa: E402
from .robot import add_activations, add_check, add_convert, add_info, add_size  # noqa: E402
from .run import add_build, add_run  # noqa: E402
from .streams import let_go, printable_streams  # noqa: E402
from .study import add_study  # noqa: E402
from .view import add_view  # noqa: E402

_COMMANDS = (
    add_init,
    add_schema,
    add_completion,
    add_run,
    add_build,
    add_check,
    add_info,
    add_convert,
    add_size,
    add_activations,
    add_excite,
    add_calibrate,
    add_device,
    add_replay,
    add_import_cad,
    add_addin,
    add_view,
    add_plot,
    add_compare,
    add_report,
    add_study,
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command.

    Args:
        arguments: Words after `cardsflow`; the process' own when None.

    Returns:
        The exit code; see `EXIT_CODES`.
    """
    with printable_streams():
        try:
            with interrupts.terminable():
                given = argparse.Namespace(started=_STARTED)
                return _run(_parsed(arguments, given))
        except KeyboardInterrupt:
            print(f"cardsflow: {interrupts.INTERRUPTED}", file=sys.stderr)
            return INTERRUPTED


def _parsed(arguments: Sequence[str] | None, given: argparse.Namespace) -> argparse.Namespace:
    """The options; SystemExit of what is printed instead, such as `--help`."""
    try:
        return _parser().parse_args(arguments, given)
    except SystemExit:
        if not _is_printed():
            raise SystemExit(FAILED) from None
        raise


def _run(options: argparse.Namespace) -> int:
    try:
        code = int(options.command(options))
        return code if _is_printed() else FAILED
    except Exception as error:
        if options.debug:
            traceback.print_exc()
        if isinstance(error, OSError):
            place = "" if error.filename is None else f"{error.filename}: "
            print(f"cardsflow: {place}{error.strerror or error}", file=sys.stderr)
            _is_printed()
            return _code_of(file_error(error, "", place)) if place else FAILED
        if isinstance(error, CardsflowError):
            print(f"cardsflow: {error}", file=sys.stderr)
            return _code_of(error)
        what = f"{type(error).__name__}: {error}"
        print(f"cardsflow: internal error: {what} (--debug shows where)", file=sys.stderr)
        return FAILED


def _is_printed() -> bool:
    """Whether all output is where it should be, as it is not on a full disk."""
    try:
        sys.stdout.flush()
        return True
    except OSError as error:
        print(f"cardsflow: {error.filename}: {error.strerror}", file=sys.stderr)
        let_go(sys.stdout)
        return False


def _code_of(error: CardsflowError) -> int:
    if isinstance(error, InputError):
        return BAD_INPUT
    reason = str(error).partition(";")[0]
    return INTERRUPTED if reason == interrupts.INTERRUPTED else FAILED


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="cardsflow",
        description="Cable-driven robots: simulate, control, package as FMUs.",
        epilog=f"example:\n  cardsflow run examples/planar_2r -o results\n\n{EXIT_CODES}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.set_defaults(parser=parser)
    parser.add_argument("--version", action="version", version=f"cardsflow {__version__}")
    commands = Commands(parser, "COMMAND")
    for add in _COMMANDS:
        add(commands)
    return parser


if __name__ == "__main__":
    sys.exit(main())
