"""A column of a table on a page of the board."""

from dataclasses import dataclass


@dataclass(frozen=True)
class PageColumn:
    name: str  # the key of a row
    title: str
    is_number: bool = False
    link: str = ""  # the key of the row with the page that it leads to
