"""Theory of soft beads that needs no run.

``integral_equations``: structure by the Ornstein-Zernike equation with the HNC closure.
``equation_of_state``: second virial coefficients, pressures of beads and of chains, and the
repulsion that gives a pressure. ``repulsion``: that between unlike beads, from chi.
"""
