"""From a folder of segmented surfaces to scenes."""
