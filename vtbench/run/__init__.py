"""The grid of a suite: cells, resume, executor."""
