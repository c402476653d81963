"""The harness and the door: datasets, tasks, runs, scores."""
