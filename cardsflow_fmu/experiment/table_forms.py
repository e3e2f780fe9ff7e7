"""The forms that a table of results is kept in."""

from typing import Literal

TableForm = Literal["csv", "parquet"]
TABLE_FORMS: tuple[TableForm, ...] = ("csv", "parquet")
