"""Slip detectors in the grid: thresholds from training trials, alarms on test trials, scores on events."""
