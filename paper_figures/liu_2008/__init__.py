"""Figures of Liu et al., J. Chem. Phys. 129, 024902 (2008), and checks of its claims."""
