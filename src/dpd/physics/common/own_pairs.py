"""Pair forces of a user's own beside the repulsion: one record whose methods add up all of them.

The engine knows one conservative force between pairs, a record with ``force(a, r, w)``, ``energy``
and ``curvature``, and takes for a the entry of its table ``repulsion`` for the two species. With
forces of one's own that table holds the number of the pair of species, by which each force finds
its own numbers. A scene without them has the plain record, and compiles nothing of this.
"""

from __future__ import annotations

import sys
from collections import namedtuple
from types import FunctionType, ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
from numba import types
from numba.extending import overload

from dpd.digest import text_digest
from dpd.jit import INLINED
from dpd.page import PairForce
from dpd.physics.common.forces import curvature, energy, force

if TYPE_CHECKING:
    from collections.abc import Sequence

STEP = 1e-5  # r_c, of the difference that stands for a curvature which a page does not give
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


def law_of_pair(record: Any, n: int) -> Any:
    """A record of numbers: those of one pair of species."""
    return type(record)(*(v[n] if isinstance(v, np.ndarray) else v for v in record))


@overload(law_of_pair, jit_options=INLINED, strict=False)  # type: ignore[arg-type]
def _law_of_pair(record, n):
    """Written out for the fields of a record; one without tables is its own law."""
    law, fields = record.instance_class, record.instance_class._fields
    if not any(isinstance(kind, types.Array) for kind in record.types):
        return lambda record, n: record
    values = ", ".join(
        f"record.{field}[n]" if isinstance(kind, types.Array) else f"record.{field}"
        for field, kind in zip(fields, record.types)
    )
    made = {"law": law}
    exec(f"def one_of(record, n):\n    return law({values})", made)
    return made["one_of"]


def record_of(page: PairForce, scene: Any) -> Any:
    """The numbers of a page, with its formulas: what they see as ``self``.

    A setting by pairs of species becomes a flat table; one that is no number is left out.
    """
    values = {}
    for name in type(page).model_fields:
        value = getattr(page, name)
        if isinstance(value, dict):
            value = np.ascontiguousarray(scene.by_pair(value).ravel())
        if isinstance(value, int | float | np.ndarray):
            values[name] = value
    return _record_class(type(page), tuple(values))(**values)


def _record_class(page, fields):
    """Made once for a page, in its module: kernels on the disk find it there.

    Its name carries the digest of the file: Numba tells the arguments of a kernel apart by the
    names of their classes, and would run the code of an edited page's former version.
    """
    module, name = sys.modules[page.__module__], f"{page.__name__}_{page.__module__}"
    known = getattr(module, name, None)
    if known is None or known._fields != fields:
        formulas = {
            key: value
            for base in reversed(page.__mro__)
            if issubclass(base, PairForce) and base is not PairForce
            for key, value in vars(base).items()
            if isinstance(value, FunctionType) and not key.startswith("_")
        }
        base = namedtuple(name, fields)
        known = type(name, (base,), {"__slots__": (), **formulas})
        known.__module__ = page.__module__
        setattr(module, name, known)
    return known


def with_own(base: Any, pages: Sequence[PairForce], scene: Any) -> Any:
    """The repulsion and some forces of one's own as one force between pairs.

    Parameters
    ----------
    base : Soft or Core
    pages : list of PairForce
    scene : Scene

    Returns
    -------
    record
        The base itself if there are no others.
    """
    if not pages:
        return base
    records = [record_of(page, scene) for page in pages]
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
            return " + ".join(f"{method}(law_of_pair(self.{each}, n), r, w)" for each in own)

        slopes = [
            f"curvature(law_of_pair(self.{each}, n), r, w)"
            if hasattr(type(record), "curvature")
            else f"(force(law_of_pair(self.{each}, n), r - {STEP}, w + {STEP}) - "
            f"force(law_of_pair(self.{each}, n), r + {STEP}, w - {STEP})) * {0.5 / STEP}"
            for each, record in zip(own, records)
        ]
        made: dict[str, Any] = {
            "force": force, "energy": energy, "curvature": curvature, "law_of_pair": law_of_pair,
        }  # fmt: skip
        formulas = SUMS.format(
            force=total("force"), energy=total("energy"), curvature=" + ".join(slopes)
        )
        exec(formulas, made)
        fields = namedtuple("Pairs", ["repulsion", "table", "base", *own])
        methods = {key: made[f"{key}_"] for key in ("force", "energy", "curvature")}
        made_class = type(name, (fields,), {"__slots__": (), **methods})
        made_class.__module__ = name
        setattr(module, name, made_class)
    return getattr(module, name)
