"""The accuracy study: what is swept, planned, run and written down."""
