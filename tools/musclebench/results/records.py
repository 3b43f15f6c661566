"""What JSON files of results hold."""

from typing import Any


def inner(record: Any, *keys: str) -> Any:
    """The value under one key after the other; None where one is missing."""
    for key in keys:
        record = record.get(key) if isinstance(record, dict) else None
    return record
