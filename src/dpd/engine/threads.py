"""Threads that advance one system together.

Each runs the same compiled loop, over beads and blocks of cells of its own, and waits for the
others where it needs what they have done. What is added up is added in an order that does not
depend on who does it, so the bits are the same for any team. (Numba's parallel loops are compiled
apart from serial ones and round differently.)
"""

from concurrent.futures import ThreadPoolExecutor
from threading import Barrier
from typing import NamedTuple

import numpy as np
from numba import types
from numba.core import cgutils

from dpd.errors import UserError
from dpd.jit import inlined, intrinsic_for

PATIENCE = 2000  # looks before a waiting thread offers its core to others
ARRIVED, PASSED = 0, 1  # counters of the barrier: threads at it, and how often it was passed
LINE = 8  # counters that fill a cache line: what one thread writes, others need not fetch again
BATCHES, BLOCKS = 0, 1  # kinds of tasks; blocks of each phase are a kind of their own

_yield_core = types.ExternalFunction("sched_yield", types.int32())


class Team(NamedTuple):
    """A thread and its team: ``rank`` of ``size``, and the ``counters`` that all share."""

    rank: int
    size: int
    counters: np.ndarray


class Share(NamedTuple):
    """Things from ``first`` up to ``end``; unsigned, as a signed index may count from the end."""

    first: int
    end: int


def new_team(size: int) -> list[Team]:
    counters = np.zeros((1 + size) * LINE, np.int64)
    return [Team(rank, size, counters) for rank in range(size)]


def started(threads: int) -> ThreadPoolExecutor:
    """Threads that are there when they are needed: the others would wait for one that is not."""
    pool, all_there = ThreadPoolExecutor(threads), Barrier(threads + 1)
    try:
        for _ in range(threads):
            pool.submit(all_there.wait)
        all_there.wait()
    except RuntimeError as problem:
        all_there.abort()
        raise UserError(f"{threads + 1} threads: {problem}; take fewer") from None
    return pool


def _fetch_add(counters, place, more):
    before = int(counters[place])
    counters[place] += more
    return before


@intrinsic_for(_fetch_add)
def fetch_add(typing, counters, place, more):
    """Add to a counter that others may add to meanwhile; return what it was."""

    def code(context, builder, signature, arguments):
        counters_type, *_ = signature.args
        array, place, more = arguments
        array = context.make_array(counters_type)(context, builder, array)
        pointer = cgutils.get_item_pointer(context, builder, counters_type, array, [place])
        return builder.atomic_rmw("add", pointer, more, "seq_cst")

    return types.int64(counters, types.int64, types.int64), code


@inlined()
def barrier(team):
    if team.size == 1:
        return
    before = fetch_add(team.counters, PASSED, 0)
    if fetch_add(team.counters, ARRIVED, 1) == team.size - 1:
        fetch_add(team.counters, ARRIVED, -team.size)
        fetch_add(team.counters, PASSED, 1)
        return
    looks = 0
    while fetch_add(team.counters, PASSED, 0) == before:
        looks += 1
        if looks > PATIENCE:
            _yield_core()


@inlined()
def next_task(team, kind, first, end):
    """One of the tasks from ``first`` to ``end`` that nobody has taken; ``end`` if all are.

    A thread begins with some, the same in every step, so that they are in its own cache; then it
    helps the others. ``kind`` is `BATCHES`, or `BLOCKS` plus the phase.
    """
    for step in range(team.size):
        owner = (team.rank + step) % team.size
        taken = fetch_add(team.counters, (1 + owner) * LINE + kind, 1)
        task = first + (end - first) * owner // team.size + taken
        if task < first + (end - first) * (owner + 1) // team.size:
            return task
    return end


@inlined()
def new_round(team):
    """Begin all tasks anew; between the barrier after the last task and that before the next."""
    for kind in range(LINE):
        team.counters[(1 + team.rank) * LINE + kind] = 0


@inlined()
def share_of(team, n):
    return Share(np.uint64(n * team.rank // team.size), np.uint64(n * (team.rank + 1) // team.size))
