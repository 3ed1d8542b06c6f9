"""Runs to numbers with errors: statistics, fits, compositions, verdicts."""
