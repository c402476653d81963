"""Backbones, PCA by modality and spectra."""
