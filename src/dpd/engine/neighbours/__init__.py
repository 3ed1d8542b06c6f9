"""Which beads are near each other: cells, the search through them, and lists."""
