"""What each effect costs a frame and what it changes: runs of one scene with effects added and taken out."""
