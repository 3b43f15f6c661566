"""How runs end."""

# Went to their end, with rows that can be measured. Suspect: something is beyond a limit that run.json states.
MEASURED = frozenset({"ok", "suspect"})
MEANINGS = {
    "ok": "The run went to its end and every outcome is within its limits.",
    "suspect": "The run went to its end, and an outcome, such as a depth, an edge or the volume, is beyond its limit. The reason "
               "stands beside it. The time was measured; look at the shape before you trust it.",
    "diverged": "Positions stopped being numbers or left the scene; there is no result.",
    "interrupted": "The run was stopped before its end.",
    "failed": "The program ended with an error.",
    "timeout": "The run took longer than it was allowed to.",
    "unsupported": "The backend can't do what the case asks for.",
    "nondeterministic": "Two runs of the same case ended in different states.",
}
