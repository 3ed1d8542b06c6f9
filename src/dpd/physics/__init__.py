"""A page a term: its settings, and force, energy and curvature as a textbook prints them."""
