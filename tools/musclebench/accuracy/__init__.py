"""What accuracy costs in time: rows, aggregates and points of a study's result folders."""
