"""What runs and sweeps say; what a single paper uses stands with it, in paper_figures."""
