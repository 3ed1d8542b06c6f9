"""Figures of the chain-revised equation of state (2019)."""
