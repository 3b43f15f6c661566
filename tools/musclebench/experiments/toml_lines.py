"""On which line of a TOML file a key stands, which the parser of the library does not tell."""

import re

HEADER = re.compile(r"^\s*(?P<open>\[\[?)\s*(?P<path>[^\]]+?)\s*\]")
KEY = re.compile(r'^\s*(?:"(?P<quoted>[^"]+)"|(?P<bare>[A-Za-z0-9_-]+))\s*[.=]')


def key_lines(text: str) -> dict[tuple, int]:
    """{path: line, from 1}. The path of a key in the second [[cases]] is ("cases", 1, key); that of a table is its own
    heading's line."""
    counts: dict[tuple, int] = {}
    prefix: tuple = ()
    lines: dict[tuple, int] = {}
    for number, line in enumerate(text.splitlines(), 1):
        if heading := HEADER.match(line):
            prefix = _prefix(heading, counts)
            lines.setdefault(prefix, number)
        elif key := KEY.match(line):
            lines.setdefault((*prefix, key["quoted"] or key["bare"]), number)
    return lines


def _prefix(heading: re.Match, counts: dict[tuple, int]) -> tuple:
    path = tuple(part.strip().strip('"') for part in heading["path"].split("."))
    if heading["open"] == "[[":
        counts[path] = counts.get(path, -1) + 1
        return (*path, counts[path])
    return (path[0], counts[path[:1]], *path[1:]) if path[:1] in counts else path


def line_of(lines: dict[tuple, int], path: tuple) -> int:
    """Of the key, or of the nearest table around it: a key of a table within one line has no line of its own."""
    while path and path not in lines:
        path = path[:-1]
    return lines.get(path, 1)
