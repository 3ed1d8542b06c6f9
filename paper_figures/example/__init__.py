"""A paper to copy."""
