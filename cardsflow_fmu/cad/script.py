"""Reader for designs that are Python programs with build123d."""

from __future__ import annotations

import runpy
import sys
from contextlib import redirect_stdout, suppress
from pathlib import Path

from addin_sdfusion.robot import CardsflowError, InputError, limits
from addin_sdfusion.robot.files import read_file

from .design import Design
from .kernel import missing


def script_design(file: Path) -> Design:
    """Execute a program and return the design in one of its global variables.

    Args:
        file: The program, which is executed with all rights of the user.

    Raises:
        InputError: The program cannot be read, fails, or does not define exactly one design.
    """
    read_file(file, limits.DESIGN)
    folder = str(file.resolve().parent)
    sys.path.insert(0, folder)
    try:
        with redirect_stdout(sys.stderr):  # the output of the command may be JSON
            variables = runpy.run_path(str(file), run_name="__cad__")
    except InputError as error:
        has_location = error.file is not None
        raise (
            error
            if has_location
            else InputError(error.problem, file=file, line=_line(error, file), key=error.key)
        ) from error
    except CardsflowError:
        raise
    except SyntaxError as error:
        raise InputError(f"is not Python: {error.msg}", file=file, line=error.lineno) from error
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] in ("build123d", "OCP"):
            raise missing() from error
        raise InputError(f"{error}", file=file, line=_line(error, file)) from error
    except (Exception, SystemExit) as error:
        problem = f"{type(error).__name__}: {' '.join(str(error).split())}".rstrip(": ")
        raise InputError(problem, file=file, line=_line(error, file)) from error
    finally:
        with suppress(ValueError):
            sys.path.remove(folder)
    designs = {id(value): name for name, value in variables.items() if isinstance(value, Design)}
    if len(designs) != 1:
        number = f"{len(designs)}: {', '.join(designs.values())}" if designs else "none"
        problem = f"must define exactly one cardsflow_fmu.cad.Design; found {number}"
        raise InputError(problem, file=file)
    return next(value for value in variables.values() if isinstance(value, Design))


def _line(error: BaseException, file: Path) -> int | None:
    """Return the line of the program that caused an error, or None."""
    at, line = error.__traceback__, None
    while at is not None:
        if at.tb_frame.f_code.co_filename == str(file):
            line = at.tb_lineno
        at = at.tb_next
    return line
