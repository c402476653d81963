"""Folders in which others hand in models or predictions: checked by numbered rules, then scored."""
