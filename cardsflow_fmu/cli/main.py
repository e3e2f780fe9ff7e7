"""The command line `cardsflow`: parsing, exit codes, error messages."""

from __future__ import annotations

import time

_STARTED = time.perf_counter()

import importlib  # noqa: E402
import sys  # noqa: E402
from collections.abc import Sequence  # noqa: E402
from typing import TYPE_CHECKING  # noqa: E402

if TYPE_CHECKING:
    import argparse

    from .parser import Parser

COMMANDS = {
    "Start": {
        "init": "setup.init.add_init",
        "examples": "setup.examples.add_examples",
        "check": "robot.add_check",
        "info": "robot.add_info",
    },
    "Simulate": {
        "run": "run.add_run",
        "build": "run.add_build",
        "play": "view.add_play",
        "view": "view.add_view",
        "report": "results.add_report",
        "plot": "results.add_plot",
        "compare": "results.add_compare",
    },
    "Analyse and design": {
        "size": "robot.add_size",
        "faults": "faults.add_faults",
        "activations": "activations.add_activations",
        "study": "study.add_study",
        "optimise": "study.add_optimise",
        "policy": "policy.add_policy",
    },
    "Hardware": {
        "device": "device.add_device",
        "replay-hardware": "device.add_replay",
        "excite": "calibrate.add_excite",
        "calibrate": "calibrate.add_calibrate",
    },
    "CAD and files": {
        "import-cad": "setup.addin.add_import_cad",
        "convert": "robot.add_convert",
        "edit": "view.add_edit",
        "addin": "setup.addin.add_addin",
    },
    "Shell and editor": {
        "schema": "setup.init.add_schema",
        "completion": "setup.init.add_completion",
    },
}
"""Function that adds each command, by group. Its module is imported when the command is used."""
_INTERRUPTED = 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command.

    All other imports are inside of functions, so that Ctrl-C never prints a traceback.

    Args:
        arguments: Words after `cardsflow` (default: arguments of the process).

    Returns:
        The exit code; see `EXIT_CODES`.
    """
    try:
        code = _main(arguments)
    except KeyboardInterrupt:  # during an import
        sys.stderr.write("cardsflow: interrupted\n")
        return _INTERRUPTED
    external = sys.modules.get("cardsflow_fmu.cosim.external_fmu")
    if arguments is None and external is not None and external.is_loaded():
        _end_process(code)
    return code


def _end_process(code: int) -> None:
    """End the process without destructors of libraries.

    Libraries of PythonFMU and pythonfmu3 release a freed object there, which corrupts the heap.
    """
    import atexit
    import os

    atexit._run_exitfuncs()
    _flush_output()
    os._exit(code)


def _main(arguments: Sequence[str] | None) -> int:
    import argparse

    from cardsflow_fmu.utils import interrupts

    from .terminal.messages import print_error
    from .terminal.streams import printable_streams

    with printable_streams():
        try:
            with interrupts.raise_on_termination() as received:
                namespace = argparse.Namespace(started=_STARTED)
                return _run(_parse(arguments, namespace), received)
        except KeyboardInterrupt:
            print_error(interrupts.INTERRUPTED)
            return _INTERRUPTED


def _parse(arguments: Sequence[str] | None, namespace: argparse.Namespace) -> argparse.Namespace:
    """Parse the options; raise SystemExit after `--help`, `--version` and usage errors."""
    words = sys.argv[1:] if arguments is None else arguments
    try:
        return _parser(words[0] if words else "").parse_args(arguments, namespace)
    except SystemExit:
        if not _flush_output():
            raise SystemExit(1) from None
        raise


def _run(options: argparse.Namespace, received: Sequence[int]) -> int:
    from .terminal.messages import quiet_messages

    try:
        with quiet_messages(options.quiet):
            code = int(options.command(options))
        return code if _flush_output() else 1
    except Exception as error:
        return _report(error, options, received)


def _report(error: Exception, options: argparse.Namespace, received: Sequence[int]) -> int:
    """Print an error and return the exit code."""
    from addin_sdfusion.robot import CardsflowError
    from addin_sdfusion.robot.files import file_error

    from .common import FAILED
    from .terminal.messages import print_error
    from .terminal.suggestions import suggest_file

    if options.debug:
        import traceback

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
    problem = f"{type(error).__name__}: {error}"
    print_error(f"internal error: {problem} (--debug prints the traceback)")
    return FAILED


def _flush_output() -> bool:
    """Flush stdout; return false if this fails, for example because the disk is full."""
    from .terminal.messages import print_error
    from .terminal.streams import discard_output

    try:
        sys.stdout.flush()
        return True
    except OSError as error:
        print_error(f"{error.filename}: {error.strerror}")
        discard_output(sys.stdout)
        return False


def _code_of(error: Exception) -> int:
    from addin_sdfusion.robot import InputError

    from .common import FAILED
    from .parser import BAD_INPUT

    if isinstance(error, InputError):
        return BAD_INPUT
    return _INTERRUPTED if _is_interruption(error) else FAILED


def _is_interruption(error: Exception) -> bool:
    from cardsflow_fmu.utils import interrupts

    return str(error).partition(";")[0] == interrupts.INTERRUPTED


def _parser(word: str = "") -> Parser:
    """Return the parser.

    Args:
        word: First word of the command line. If it is a command, the parser only has this command;
            for `--version` it has no command, otherwise all.
    """
    from cardsflow_fmu.version import __version__

    from .parser import EXIT_CODES, Commands, Parser

    parser = Parser(
        prog="cardsflow",
        description="Simulate and control musculoskeletal (cable-driven) robots; build their FMUs.",
        epilog="example:\n  cardsflow run examples/planar_2r -o results\n\n"
        f"`cardsflow COMMAND --help` lists the options of a command.\n\n{EXIT_CODES}",
    )
    parser.set_defaults(parser=parser)
    parser.add_argument("--version", action="version", version=f"cardsflow {__version__}")
    commands = Commands(parser, "COMMAND")
    all_commands = {name for group in COMMANDS.values() for name in group} - {"completion"}
    used = {word} & all_commands or ({} if word == "--version" else all_commands | {"completion"})
    for title, group in COMMANDS.items():
        commands.start_group(title)
        for name in filter(used.__contains__, group):
            module, _, add = group[name].rpartition(".")
            getattr(importlib.import_module(f"{__package__}.{module}"), add)(commands)
    return parser


if __name__ == "__main__":
    sys.exit(main())
