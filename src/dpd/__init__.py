"""dpd-papers: regenerate the figures of three dissipative particle dynamics papers."""

__version__ = "0.1.0"
