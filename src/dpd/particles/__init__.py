"""Beads and bonds as files: those that this program writes, GSD, and LAMMPS data."""
