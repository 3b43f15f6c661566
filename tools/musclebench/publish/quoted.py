"""Which numbers of a page are quoted, and so have to stand between markers. The rule is told in CONTRIBUTING.md:

a number is quoted where it has a unit of time, memory, length, share or rate, or is a ratio (`3 times`, `four times`,
`twice as`, `2 x`, `1.5 voxel tests`, `two fifths`), or has decimals, or fills a cell of a table. Not quoted is what stands as code (`0.1 mm`:
an option, a setting, a target), in a link, or in a name (FCL 0.7)."""

import re

from .pages import MARKED

UNITS = (r"ms|us|µs|ns|s|min|h|seconds?|minutes?|hours?|GB|MB|kB|MiB|KiB|bytes?|mm|nm|µm|%|percent|fps|frames/s|"
         r"cycles|times|fold|x|voxel tests?")
NUMBER = r"\d+(?:,\d{3})*(?:\.\d+)?(?:e-?\d+)?"
# An upper-case letter before: the version in a name.
WITH_UNIT = re.compile(rf"(?<![\w.])({NUMBER})(?:\s?(?:to|and|-)\s?{NUMBER})?\s?(?:{UNITS})(?![\w/])")
DECIMAL = re.compile(r"(?<![\w./:])(?<![A-Z+] )(\d+\.\d+)(?![\w./])")
CELL = re.compile(r"(?<=\|)\s*([~<>]?\d[\d,.]*(?: to [\d,.]+)?)\s*(?=\|)")
# In words; thirds are the geometry's.
SHARE = re.compile(r"\b((?:one|two|three|four|five|six|seven|eight|nine)\s(?:half|(?:quarter|fifth|eighth|tenth)s?))\b"
                   r"(?!\s(?:sphere|space|plane|edge|diagonal))", re.IGNORECASE)
# "The three times" are durations; twice a length, or half of one, is geometry.
WORD_RATIO = re.compile(r"(?<!\bthe )\b((?:two|three|four|five|six|seven|eight|nine|ten|twelve|twenty|fifty|(?:hundred|thousand)s?)"
                        r"(?:\sof)?\s(?:times|fold)|(?:twice|half)\sas)\b", re.IGNORECASE)
NOT_PROSE = [
    MARKED,
    re.compile(r"```.*?```", re.DOTALL),
    re.compile(r"<!--.*?-->", re.DOTALL),
    re.compile(r"`[^`\n]*`"),
    re.compile(r"\$\$.*?\$\$", re.DOTALL),
    re.compile(r"\$[^$]*\$"),
    re.compile(r"\]\([^)]*\)"),
    re.compile(r"https?://\S+|doi:\S+"),
]


def unmarked(text: str) -> list[tuple[int, str]]:
    """(line, text) of each number that is quoted outside of markers."""
    for pattern in NOT_PROSE:
        text = pattern.sub(lambda match: re.sub(r"[^\n]", " ", match.group(0)), text)
    found = {(match.start(1), match.group(0).strip())
             for pattern in (WITH_UNIT, DECIMAL, CELL, SHARE, WORD_RATIO) for match in pattern.finditer(text)}
    longest_at: dict[int, str] = {}
    for offset, words in sorted(found, key=lambda one: (one[0], -len(one[1]))):
        longest_at.setdefault(offset, words)
    return [(text.count("\n", 0, offset) + 1, words) for offset, words in longest_at.items()]
