"""What runs and sweeps say, with errors that know about correlation.

    ``statistics``: means, jackknife, fits, intervals of counts, degrees of freedom of any error.
    ``structure``: g(r), contacts, pressure. ``diffusion``: displacements, D,
    relaxation of chains. ``interfaces``: slabs, widths, chi. ``viscosity``: also at rest.
    ``collect``: the runs of a sweep on its axes. ``verdicts``: printed numbers against ours.

What a single paper uses stands with it, in paper_figures.
"""
