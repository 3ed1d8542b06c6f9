"""A page says everything about one thing: settings, what it does, what it cannot be combined with.

It is a class in a file that is called by its key: a scene imports only the pages that it names.
Nothing at the top of a page imports Numba: kernels come with the first step.
"""

# ruff: noqa: F401
# isort: off
from dpd.page.base import (
    LARGEST_SEED, MOST_STEPS, NAMES, PARTS, Axis, Calculation, Change, NotNegative, OneOr,
    OneOrMore, OneOrTable, Page, Pair, PairTable, PerPair, PerSpecies, Positive, Quantity, Refusals,
    Section, Species, Table, Triple, check_table, find, inside, is_table, names, no_species, once,
    part, setting,
)  # fmt: skip
from dpd.page.kinds import (
    KINDS, NEEDED, BondedForce, BondForce, Given, Observable, PairForce, Start, Term,
)  # fmt: skip
