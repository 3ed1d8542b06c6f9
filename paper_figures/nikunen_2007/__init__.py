"""Figures of Nikunen et al., Phys. Rev. E 75, 036713 (2007), and checks of its claims."""
