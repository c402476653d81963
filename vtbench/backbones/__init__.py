"""Backbones side by side: what a frame costs, what a run scored, and the two in one picture."""
