"""How runs end."""

# Went to their end, with rows that can be measured. Suspect: something is beyond a limit that run.json states.
MEASURED = frozenset({"ok", "suspect"})
