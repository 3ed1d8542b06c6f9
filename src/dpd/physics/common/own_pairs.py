"""Pair forces of a user's own beside the repulsion: one record whose methods add up all of them.

The engine knows one conservative force between pairs, a record with ``force(a, r, w)``, ``energy``
and ``curvature``, and takes for a the entry of its table ``repulsion`` for the two species. With
forces of one's own that table holds the number of the pair of species, by which each force finds
its own numbers. A scene without them has the plain record, and compiles nothing of this.
"""

from __future__ import annotations

import sys
from collections import namedtuple
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.digest import text_digest
from dpd.physics.common.forces import curvature, energy, force, law_of
from dpd.physics.common.records import pair_record

if TYPE_CHECKING:
    from collections.abc import Sequence

    from dpd.page import PairForce

METHODS = ("force", "energy", "curvature")
SUMS = """
def force_(self, a, r, w):
    n, r, inside = int(a), min(r, 1.0), 1.0 if w > 0.0 else 0.0
    return force(self.base, self.table[n], r, w) + inside * ({force})

def energy_(self, a, r, w):
    n, r, inside = int(a), min(r, 1.0), 1.0 if w > 0.0 else 0.0
    return energy(self.base, self.table[n], r, w) + inside * ({energy})

def curvature_(self, a, r, w):
    n, r, inside = int(a), min(r, 1.0), 1.0 if w > 0.0 else 0.0
    return curvature(self.base, self.table[n], r, w) + inside * ({curvature})
"""


def with_own(base: Any, pages: Sequence[PairForce], scene: Any) -> Any:
    """The repulsion and some forces of one's own as one force between pairs."""
    records = [pair_record(page, scene) for page in pages]
    size = len(base.repulsion)
    number = np.arange(size * size, dtype=np.float64).reshape(size, size)
    table = np.ascontiguousarray(base.repulsion.ravel(), dtype=np.float64)
    return _sum_class(base, records)(number, table, base, *records)


def _sum_class(base, records):
    """The class of the record of all, in a module that is called by what it sums up."""
    parts = [f"{type(each).__module__}.{type(each).__name__}" for each in (base, *records)]
    name = f"own_pairs_{text_digest(' '.join(parts))}"
    module = sys.modules.setdefault(name, ModuleType(name))
    if not hasattr(module, name):
        own = [f"own{number}" for number in range(len(records))]

        def total(method):
            return " + ".join(f"{method}(law_of(self.{each}, n), r, w)" for each in own)

        made: dict[str, Any] = {
            "force": force, "energy": energy, "curvature": curvature, "law_of": law_of,
        }  # fmt: skip
        exec(SUMS.format(**{method: total(method) for method in METHODS}), made)
        fields = namedtuple("Pairs", ["repulsion", "table", "base", *own])
        methods = {key: made[f"{key}_"] for key in METHODS}
        made_class = type(name, (fields,), {"__slots__": (), **methods})
        made_class.__module__ = name
        setattr(module, name, made_class)
    return getattr(module, name)
