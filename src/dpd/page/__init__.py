"""What a page is: it says everything about one thing, and the house asks it.

A page is a class in a file of its own: its settings, what it does to the world, and what it cannot
be combined with. It registers by being a subclass of its kind with a key. The key is the name of
its file, so reading a scene imports no page that the scene does not name. Nothing at the top of a
page imports Numba: kernels come with the first step.
"""

# ruff: noqa: F401
# isort: off
from dpd.page.base import (
    LARGEST_SEED, MOST_STEPS, NAMES, OR_LIST, OR_TABLE, PARTS, Axis, Calculation, Change,
    NotNegative, OneOrMore, OneOrTable, Page, Pair, PairTable, PerPair, PerSpecies, Positive,
    Quantity, Refusals, Section, Species, Triple, check_table, find, inside,
    interval_setting, is_table, module_of, names, no_species, once, part, setting,
)  # fmt: skip
from dpd.page.kinds import (
    KINDS, NEEDED, BondedForce, BondForce, Given, Observable, PairForce, Start, Term,
)  # fmt: skip
