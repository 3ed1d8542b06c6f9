"""Figures of the DPD chapter of the Cerius2 manual of 1998."""
