"""Each kind of molecule in a slab of its own."""

from dpd.start.random import Random


class Slabs(Random, key="slabs"):
    """Each kind of molecule in a slab of its own along the longest axis."""

    in_slabs = True
