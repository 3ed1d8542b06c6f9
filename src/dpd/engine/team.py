"""Threads that advance one system together.

Each runs the same compiled loop, over beads and layers of cells of its own, and waits for the
others where it needs what they have done. (Numba's parallel loops are compiled apart from
serial ones and round differently. Here one thread and many run the same code, and what is
added up is added in an order that does not depend on who does it: the bits are the same.)
"""

from typing import NamedTuple

import numpy as np
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from dpd.engine.jit import part

PATIENCE = 2000  # looks before a waiting thread offers its core to others
ARRIVED, MEETINGS, BATCHES, LAYERS = range(4)
PHASES = 3  # of the layers: see `layer_of`

_yield_core = types.ExternalFunction("sched_yield", types.int32())


class Team(NamedTuple):
    """A thread and its team: ``rank`` of ``size``, and the ``counters`` that all share."""

    rank: int
    size: int
    counters: np.ndarray


def new_team(size):
    """One `Team` per thread."""
    counters = np.zeros(LAYERS + PHASES, np.int64)
    return [Team(rank, size, counters) for rank in range(size)]


@intrinsic
def add_and_tell(typing, counters, place, more):
    """Add to a counter that others may add to meanwhile; return what it was."""

    def code(context, builder, signature, arguments):
        counters_type = signature.args[0]
        array = context.make_array(counters_type)(context, builder, arguments[0])
        place = cgutils.get_item_pointer(context, builder, counters_type, array, [arguments[1]])
        return builder.atomic_rmw("add", place, arguments[2], "seq_cst")

    return types.int64(counters, types.int64, types.int64), code


@part()
def meet(team):
    """Wait until all threads are here."""
    if team.size == 1:
        return
    before = add_and_tell(team.counters, MEETINGS, 0)
    if add_and_tell(team.counters, ARRIVED, 1) == team.size - 1:
        add_and_tell(team.counters, ARRIVED, -team.size)
        add_and_tell(team.counters, MEETINGS, 1)
        return
    looks = 0
    while add_and_tell(team.counters, MEETINGS, 0) == before:
        looks += 1
        if looks > PATIENCE:
            _yield_core()


@part()
def take(team, tasks):
    """Number of the next task of a kind that nobody has taken.

    Kinds are `BATCHES`, and `LAYERS` plus the phase.
    """
    return add_and_tell(team.counters, tasks, 1)


@part()
def new_round(team):
    """Begin all tasks anew; between a meeting after the last is done and one before the next."""
    if team.rank == 0:
        for tasks in range(BATCHES, len(team.counters)):
            team.counters[tasks] = 0


@part()
def layers_in(phase, layers):
    """How many layers of cells a phase has.

    Pairs of a layer push beads of that layer and of the next. So layers with even numbers
    can be worked on at the same time, and then those with odd ones. Of an odd number of layers
    the last, which touches the first, comes alone in the end.
    """
    return layers // 2 if phase < 2 else layers % 2


@part()
def layer_of(phase, task, layers):
    """Number of a phase's layer."""
    return 2 * task + phase if phase < 2 else layers - 1


@part()
def share(team, n):
    """First and end of a thread's own part of n things.

    Unsigned, as a signed index is looked at whether it counts from the end, in every loop.
    """
    return np.uint64(n * team.rank // team.size), np.uint64(n * (team.rank + 1) // team.size)
