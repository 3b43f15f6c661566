"""Random scenes, and a count of what passes through what that shares no code with the program."""
