"""How runs end."""

# Went to their end, with rows that can be measured. Suspect: something is beyond a limit that run.json states.
MEASURED = frozenset({"ok", "suspect"})
MEANINGS = {
    "ok": "The run reached its end, and every outcome is within its limits.",
    "suspect": "The run reached its end, but an outcome is beyond its limit (a depth, an edge, the volume), an answer is off by more than "
               "its backend declares, or the scene is wrong (a unit, an attachment without nodes). The status gives the reason. The time "
               "is valid. Look at the shape before you trust the result.",
    "diverged": "Positions became infinite or left the scene. There is no result.",
    "interrupted": "Somebody stopped the run before its end.",
    "failed": "The program ended with an error.",
    "timeout": "The run reached its time limit.",
    "unsupported": "The backend cannot do this case.",
    "nondeterministic": "Two runs of the same case ended in different states.",
}
