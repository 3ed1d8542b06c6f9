"""Records of numbers with the formulas of a page: what kernels get of pair forces and bonds.

The engine knows one conservative force between pairs, a record with ``force(a, r, w)``, ``energy``
and ``curvature``, and takes for a the entry of its table ``repulsion`` for the two species. With
pair forces of a user's own beside the repulsion one record adds up all of them, and that table
holds the number of the pair of species, by which each force finds its own numbers.
"""

from __future__ import annotations

import sys
from collections import namedtuple
from types import FunctionType, ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.digest import text_digest
from dpd.laws import numbers_of
from dpd.page import Section
from dpd.physics.common.forces import curvature, energy, force, law_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from dpd.page import PairForce

STEP = 1e-5  # r_c, of the difference that stands for a curvature which a page does not give
PER_STEP = 0.5 / STEP
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


def curvature_of_pair(self: Any, r: float, w: float) -> float:
    return (force(self, r - STEP, w + STEP) - force(self, r + STEP, w - STEP)) * PER_STEP


def curvature_of_bond(self: Any, r: float) -> float:
    return (force(self, r - STEP) - force(self, r + STEP)) * PER_STEP


def force_over_r(self: Any, r: float) -> float:
    return force(self, r) / r


def record_class(
    page: type[Section], fields: Iterable[str], **others: Callable[..., Any]
) -> type[Any]:
    """A NamedTuple with the formulas of a page, and others that it does not give.

    It is made once, in the module of the page: kernels on the disk find it there. Its name carries
    that of the module, in which for a file of one's own is its digest: Numba tells the arguments of
    a kernel apart by the names of their classes, and would run the code of an edited page's former
    version.
    """
    module, fields = sys.modules[page.__module__], tuple(fields)
    name = f"{page.__name__}_{page.__module__}".replace(".", "_")
    known = getattr(module, name, None)
    if known is None or known._fields != fields:
        formulas = {
            key: value
            for base in reversed(page.__mro__)
            if issubclass(base, Section) and base.__module__ != Section.__module__
            for key, value in vars(base).items()
            if isinstance(value, FunctionType) and not key.startswith("_")
        }
        known = type(name, (namedtuple(name, fields),), {"__slots__": (), **others, **formulas})
        known.__module__ = page.__module__
        setattr(module, name, known)
    return known


def pair_record(page: PairForce, scene: Any) -> Any:
    """The numbers of a pair force: what its formulas see as ``self``.

    A setting by pairs of species becomes a flat table; one that is no number is left out.
    """
    values = page.numbers(scene)
    for name in type(page).model_fields if not values else ():
        value = getattr(page, name)
        if isinstance(value, dict):
            value = np.ascontiguousarray(scene.by_pair(value).ravel())
        if isinstance(value, int | float | np.ndarray):
            values[name] = value
    return record_class(type(page), values, curvature=curvature_of_pair)(**values)


def bond_record(laws: Sequence[Any], number: np.ndarray | None) -> Any:
    """The numbers of laws along bonds; where they differ with the place, (n,) uint16, of each."""
    each = [numbers_of(law) for law in laws]
    values: dict[str, Any] = each[0]
    if number is not None:
        values = {name: np.array([numbers[name] for numbers in each]) for name in values}
    made = record_class(
        type(laws[0]), (*values, "number"), force_over_r=force_over_r, curvature=curvature_of_bond
    )
    return made(**values, number=number)


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
