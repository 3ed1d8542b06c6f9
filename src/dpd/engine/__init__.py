"""HOW beads move, fast: state, neighbours, threads, the step, the run loop, checkpoints.

Knows NumPy, Numba and `dpd.physics` only: no paper, no file format of the pipeline, no Snakemake.
"""
