"""Colours as texts."""

from __future__ import annotations

import re
from typing import Annotated

from ..records import Form

COLOR = re.compile("#[0-9a-fA-F]{6}", re.ASCII)
Color = Annotated[str, Form("#rrggbb", COLOR.pattern)]
