"""Household shapes as heightfields."""
