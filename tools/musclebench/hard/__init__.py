"""The matrix of hard cases: which backend holds in which."""
