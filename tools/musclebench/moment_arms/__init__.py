"""Moment arms of a muscle's fibres over a joint's range, beside published ones."""
