"""Settings that refer to custom control laws and muscle laws; the files are not executed here."""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import NamedTuple, Self

from addin_sdfusion.robot import InputError, UnknownNameError, limits
from addin_sdfusion.robot.files import read_file

_CUSTOM_LAW = re.compile(r"(?P<file>.+\.py):(?P<name>[^\W\d]\w*)", re.DOTALL)
CUSTOM_LAW_FORM = "<file>.py:<class>"
CUSTOM_LAW_SCHEMA = {"type": "string", "pattern": r"\.py:\w+$"}


class CustomLaw(NamedTuple):
    """Custom control law or muscle law: a class in a Python file."""

    file: Path
    name: str

    @classmethod
    def of(cls, law: str) -> Self | None:
        """Parse a setting; return None for the name of a built-in law."""
        match = _CUSTOM_LAW.fullmatch(law)
        return None if match is None else cls(Path(match["file"]), match["name"])

    def __str__(self) -> str:
        return f"{self.file.as_posix()}:{self.name}"

    def require(self) -> ast.ClassDef:
        """Return the syntax tree of the class; the file is not executed.

        Raises:
            InputError: The file cannot be read, is not Python, or does not define the class.
        """
        try:
            tree = ast.parse(read_file(self.file, limits.CODE))
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            line = error.lineno if isinstance(error, SyntaxError) else None
            problem = f"is not valid Python: {getattr(error, 'msg', error)}"
            raise InputError(problem, file=self.file, line=line) from None
        classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
        if self.name not in classes:
            raise UnknownNameError("class", self.name, classes, file=self.file)
        return classes[self.name]
