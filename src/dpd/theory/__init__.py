"""Theory of soft beads that needs no run."""
