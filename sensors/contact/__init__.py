"""Contact rungs and the oracles that test them."""
