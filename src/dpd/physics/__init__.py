"""What acts on beads, a page a term, and the schemes that move them.

Each page has the parameters of its term as a named record, and force, energy and curvature side by
side, as a textbook prints them. Nothing here knows how pairs are found.
"""
