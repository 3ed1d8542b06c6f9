"""The record of all that acts on beads, and how kernels call a term of it.

A term is a page of this package: a record whose methods are its force, its energy and its
curvature. Numba knows the class of a record when it compiles, so `force(term, ...)` in a kernel
becomes the method of that class and nothing else: terms that a scene does not name cost nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numba import types
from numba.extending import overload

from dpd.jit import INLINED, method

if TYPE_CHECKING:
    from dpd.physics.body_force import BodyForce
    from dpd.physics.common.exchange import Exchange
    from dpd.physics.common.langevin import Langevin
    from dpd.physics.core import Core
    from dpd.physics.many_body import ManyBody
    from dpd.physics.repulsion import Soft
    from dpd.physics.thermostat import Friction
    from dpd.physics.walls import Walls


class Forces(NamedTuple):
    """What acts on beads; None for what does not."""

    pair: Soft | Core  # the conservative force between pairs
    many_body: ManyBody | None = None
    bond: Any = None  # see `dpd.physics.common.records.bond_record`
    angle: Any = None
    friction: Friction | None = None
    langevin: Langevin | None = None
    exchange: Exchange | None = None  # the thermostat is one of these three
    walls: Walls | None = None
    body_force: BodyForce | None = None


def law_of(laws: Any, place: int) -> Any:
    """A record with one number in the place of each of its columns; itself if it has none.

    The place is in the columns, or, if one of them is called ``number``, in that, which has the
    place in the others.
    """
    columns = [isinstance(value, np.ndarray) and value.ndim == 1 for value in laws]
    if not any(columns):
        return laws
    number = getattr(laws, "number", None)
    n = place if number is None else number[place]
    law = type(laws)(*(value[n] if many else value for value, many in zip(laws, columns)))
    return law if number is None else law._replace(number=None)


@overload(law_of, jit_options=INLINED, strict=False)  # type: ignore[arg-type]
def _law_of(laws, place):
    """Written out for the fields of a record."""
    law, fields = laws.instance_class, laws.instance_class._fields
    columns = [isinstance(kind, types.Array) and kind.ndim == 1 for kind in laws.types]
    if not any(columns):
        return lambda laws, place: laws
    given = {field: f"laws.{field}" for field in fields}
    many = {field for field, column in zip(fields, columns) if column}
    n = "laws.number[place]" if "number" in many else "place"
    given |= {field: f"laws.{field}[{n}]" for field in many} | {"number": "None"}
    made = {"law": law}
    values = ", ".join(given[field] for field in fields)
    exec(f"def one_of(laws, place):\n    return law({values})", made)
    return made["one_of"]


# What a kernel calls with a term as the first argument; 0 for one that is absent.
force = method("force")
force_over_r = method("force_over_r")
energy = method("energy")
curvature = method("curvature")
drag = method("drag")
random = method("random")
change = method("change")
weight = method("weight")
slope = method("slope")
