"""The record of all that acts on beads, what it is made of, and how kernels call a term of it.

`force(term, ...)` in a kernel becomes the method of the term's class. The engine knows one force
between pairs, ``force(a, r, w)``, with a from the table ``repulsion``. Where there are several one
record adds them up, and that table holds the number of the pair of species, by which each finds its
own.
"""

from __future__ import annotations

import sys
from collections import namedtuple
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from types import FunctionType, ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numba import types
from numba.extending import overload

from dpd.digests import text_digest
from dpd.jit import INLINED, inlined, method
from dpd.page import PairForce, Section

if TYPE_CHECKING:
    from dpd.physics.body_force import BodyForce
    from dpd.physics.core import Core
    from dpd.physics.integrator import Exchange
    from dpd.physics.many_body import ManyBody
    from dpd.physics.repulsion import Soft
    from dpd.physics.thermostat import Friction
    from dpd.physics.walls import Walls

STEP = 1e-5  # r_c, of the difference that stands for a curvature which a page does not give
PER_STEP = 0.5 / STEP


class Forces(NamedTuple):
    """What acts on beads; None for what does not."""

    pair: Soft | Core  # the conservative force between pairs
    many_body: ManyBody | None = None
    bond: Any = None  # see `bond_record`
    angle: Any = None
    friction: Friction | None = None
    langevin: Friction | None = None  # on each bead
    exchange: Exchange | None = None  # the thermostat is one of these three
    walls: Walls | None = None
    body_force: BodyForce | None = None


def law_of(laws: Any, place: int) -> Any:
    """A record with one number for each of its columns, of which ``number`` has the place."""
    law: Any = type(laws)
    return _one_of(law, tuple(np.ndim(value) == 1 for value in laws))(laws, place)


@overload(law_of, jit_options=INLINED, strict=False)  # type: ignore[arg-type]
def _law_of(laws, place):
    columns = tuple(isinstance(kind, types.Array) and kind.ndim == 1 for kind in laws.types)
    return _one_of(laws.instance_class, columns)


@cache
def _one_of(law, columns):
    """Written out for the fields of a record, of which some are columns."""
    many = {field for field, column in zip(law._fields, columns) if column}
    if not many:
        return lambda laws, place: laws
    n = "laws.number[place]" if "number" in many else "place"
    values = [f"laws.{field}[{n}]" if field in many else f"laws.{field}" for field in law._fields]
    values = ["None" if field == "number" else v for field, v in zip(law._fields, values)]
    made = {"law": law}
    exec(f"def one_of(laws, place):\n    return law({', '.join(values)})", made)
    return made["one_of"]


# What a kernel calls with a term as the first argument; 0 for one that is absent.
force = method("force")
energy = method("energy")
curvature = method("curvature")
drag = method("drag")
random = method("random")
change = method("change")
weight = method("weight")
slope = method("slope")


# --- numbers with the formulas of a page


def curvature_of_pair(self: Any, r: float, w: float) -> float:
    return (force(self, r - STEP, w + STEP) - force(self, r + STEP, w - STEP)) * PER_STEP


def curvature_of_bond(self: Any, r: float) -> float:
    return (force(self, r - STEP) - force(self, r + STEP)) * PER_STEP


def record_class(
    page: type[Section], fields: Iterable[str], **others: Callable[..., Any]
) -> type[Any]:
    """A NamedTuple with the formulas of a page, and others that it does not give.

    It stands in the page's module, where kernels on the disk find it, and has its name: Numba tells
    classes apart by names.
    """
    module, fields = sys.modules[page.__module__], tuple(fields)
    name = f"{page.__name__}_{page.__module__}".replace(".", "_")
    known = getattr(module, name, None)
    if known is None or known._fields != fields:
        formulas = {
            key: value
            for base in reversed(page.__mro__) if issubclass(base, Section)
            for key, value in vars(base).items()
            if isinstance(value, FunctionType) and not key.startswith("_")
        }  # fmt: skip
        known = type(name, (namedtuple(name, fields),), {"__slots__": (), **others, **formulas})
        known.__module__ = page.__module__
        setattr(module, name, known)
    return known


def pair_record(page: PairForce, scene: Any) -> Any:
    """The numbers of a pair force, ``self`` of its formulas; by pairs of species a flat table."""
    values = page.numbers(scene)
    return record_class(type(page), values, curvature=curvature_of_pair)(**values)


def bond_record(laws: Sequence[Any], number: np.ndarray | None) -> Any:
    """The numbers of laws along bonds; where they differ with the place, (n,) uint16, of each."""
    each = [{name: float(v) for name, v in law if isinstance(v, int | float)} for law in laws]
    values: dict[str, Any] = each[0]
    if number is not None:
        values = {name: np.array([numbers[name] for numbers in each]) for name in values}
    made = record_class(type(laws[0]), (*values, "number"), curvature=curvature_of_bond)
    return made(**values, number=number)


def with_own(base: Any, pages: Sequence[PairForce], scene: Any) -> Any:
    """The repulsion and some forces of one's own as one force between pairs."""
    records = [pair_record(page, scene) for page in pages]
    size = len(base.repulsion)
    number = np.arange(size * size, dtype=np.float64).reshape(size, size)
    table = np.ascontiguousarray(base.repulsion.ravel(), dtype=np.float64)
    return _sum_class(base, records)(number, table, base, *records)


SUM = """
def {name}(self, a, r, w):
    n, r, inside = int(a), min(r, 1.0), 1.0 if w > 0.0 else 0.0
    return call(self.base, self.table[n], r, w) + inside * ({total})
"""


def _sum_class(base, records):
    """The class of the record of all, in a module that is called by what it sums up."""
    summed = [f"{type(each).__module__}.{type(each).__name__}" for each in (base, *records)]
    name = f"own_pairs_{text_digest(' '.join(summed))}"
    module = sys.modules.setdefault(name, ModuleType(name))
    if not hasattr(module, name):
        own = [f"own{number}" for number in range(len(records))]
        total = " + ".join(f"call(law_of(self.{each}, n), r, w)" for each in own)
        methods = {}
        for key, call in {"force": force, "energy": energy, "curvature": curvature}.items():
            made: dict[str, Any] = {"call": call, "law_of": law_of}
            exec(SUM.format(name=key, total=total), made)
            methods[key] = made[key]
        fields = namedtuple("Pairs", ["repulsion", "table", "base", *own])
        made_class = type(name, (fields,), {"__slots__": (), **methods})
        made_class.__module__ = name
        setattr(module, name, made_class)
    return getattr(module, name)


@inlined()
def of_pair(values, species, i, j):
    """The value for the species of the beads in slots i and j; 1 without values."""
    if values is None:
        return 1.0
    if species is None:
        return values[0, 0]
    return values[species[i], species[j]]


@inlined()
def of_bead(values, species, s):
    """The value for the species of the bead in slot s; 1 without values."""
    if values is None:
        return 1.0
    if species is None:
        return values[0]
    return values[species[s]]
