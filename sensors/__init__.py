"""Scenes in, paired recordings out: contact, taxel electronics and optics of simulated tactile sensors."""
