"""Figures of Groot and Warren, J. Chem. Phys. 107, 4423 (1997), and numbers of its text."""
