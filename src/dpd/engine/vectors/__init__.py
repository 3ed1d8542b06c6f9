"""Instructions that the compiler does not find by itself: rows of beads and sets of bits."""
