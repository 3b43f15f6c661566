"""libFuzzer over the readers of files."""
