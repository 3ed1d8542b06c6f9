"""dpd-papers: regenerate the figures of three dissipative particle dynamics papers."""
