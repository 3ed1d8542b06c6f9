"""Which run of a study comes first, where not all can run at once."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from dpd.pipeline.study import Paper


def priorities(
    papers: Mapping[str, Paper], first: Sequence[str] = ()
) -> dict[tuple[str, str, str], int]:
    """Priorities of all runs: that of the highest number begins first.

    The longest run comes first, so that none is left to the end, where a core would wait for it.
    The study may name sweeps that come before, in the order of their worth; the shortest run of
    each of these comes first, so that much of it is whole whenever somebody stops the study.

    Parameters
    ----------
    papers : dict of str to Paper
    first : sequence of str
        Sweeps as ``paper.sweep``, the one of the greatest worth in front. Those of papers that are
        not among ``papers`` do nothing.

    Returns
    -------
    dict
        From paper, sweep and point to a number from 1 up.
    """
    work = {
        (paper.name, sweep.name, point.name): round(point.scene.work / 1e6)
        for paper in papers.values()
        for sweep in paper.sweeps.values()
        for point in sweep.points
    }
    most = 1 + max(work.values(), default=0)
    worth = {name: len(first) - place for place, name in enumerate(first)}
    return {
        run: 1 + _before(worth.get(f"{run[0]}.{run[1]}"), amount, most)
        for run, amount in work.items()
    }


def _before(worth, amount, most):
    """Number of a run by the worth of its sweep, None for those that the study does not name."""
    return amount if worth is None else worth * most + (most - amount)
