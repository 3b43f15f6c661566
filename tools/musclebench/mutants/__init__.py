"""Puts listed one-line faults into the code, one at a time, and says which of them no test program sees."""
