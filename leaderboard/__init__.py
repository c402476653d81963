"""Records in, tables that can be trusted out."""
