"""Whose shapes runs have: what their scenes say of the source."""

from collections.abc import Iterable
from typing import Any


def licences_of(records: Iterable[dict[str, Any]]) -> list[str]:
    """Each once, as "CC BY 4.0", with what it forbids."""
    sources = [record["source"] for record in records if record.get("source")]
    return list(dict.fromkeys(f"{one['licence']}{', not for commercial use' if one.get('non_commercial') else ''}" for one in sources))


def citations_of(records: Iterable[dict[str, Any]]) -> list[str]:
    return list(dict.fromkeys(text for record in records for text in (record.get("source") or {}).get("cite", [])))
