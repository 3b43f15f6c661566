"""Progress of a tool without cases."""

import sys
import time

SILENT_S = 2.0


class Talker:
    """Says what is being done, with the seconds so far, once the work has lasted two seconds."""

    def __init__(self, tool: str):
        self.tool, self.start = tool, time.monotonic()

    def __call__(self, text: str) -> None:
        passed = time.monotonic() - self.start
        if passed > SILENT_S:
            print(f"{self.tool}: {passed:4.0f} s: {text}", file=sys.stderr, flush=True)
