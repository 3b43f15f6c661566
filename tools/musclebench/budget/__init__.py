"""Where the error of a run comes from: each source of error refined alone, and what halving it costs."""
