"""What runs and sweeps say, with errors that know about correlation.

    Errors ``statistics``: means, jackknife, fits, intervals of counts, degrees of freedom of any
    error. Quantities ``structure``: g(r), its peak, closest contact, bonds. ``diffusion``:
    functions of time by molecules and by parts of runs, exponents, D. ``relaxation``: end-to-end
    correlation, tau, power laws of chain length. ``interfaces``: slabs, widths, coexisting phases
    and chi. ``pressure``: equations of state. ``viscosity``: under shear, in driven flows, at rest.
    ``surface_tension``: of slabs. ``morphology``: lamellae and cylinders, by the structure factor.
    Papers ``collect``: the runs of a sweep on its axes. ``derive``: values of scenes that another
    sweep measures. ``published`` and ``verdicts``: printed numbers against ours.

What a single paper uses stands with it, in paper_figures.
"""
