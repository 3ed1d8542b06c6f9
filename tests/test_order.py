"""Which run of a study begins first, and what jobs ask a cluster for."""

import pytest

from dpd.pipeline.jobs import RATE, batches, megabytes, minutes, priorities
from dpd.pipeline.paper import read_paper
from dpd.start import start_digest, start_is_shared


@pytest.fixture(scope="module")
def papers():
    """Two papers under the study quick."""
    return {name: read_paper(name, "quick") for name in ("liu_2008", "nikunen_2007")}


def in_order(papers, first=()):
    """Paper, sweep and work of all runs, the highest priority in front."""
    found = priorities(papers, first)
    runs = sorted(found, key=found.get, reverse=True)
    return [
        (paper, sweep, papers[paper].sweeps[sweep].point(point).scene.work)
        for paper, sweep, point in runs
    ]


def test_the_longest_run_is_first(papers):
    """All runs of a study, by their work in millions of bead-steps."""
    work = [round(amount / 1e6) for *_, amount in in_order(papers)]
    sweeps = [sweep for paper in papers.values() for sweep in paper.sweeps.values()]
    assert len(work) == sum(len(sweep.points) for sweep in sweeps)
    assert work == sorted(work, reverse=True)
    assert min(priorities(papers).values()) > 0


def test_sweeps_that_come_first(papers):
    """In their order, each from its shortest run; the others as without."""
    first = ["nikunen_2007.dynamics", "liu_2008.melts", "groot_warren_1997.chains"]
    runs = [
        (f"{paper}.{sweep}", round(work / 1e6)) for paper, sweep, work in in_order(papers, first)
    ]
    front = [run for run in runs if run[0] in first]
    assert {name for name, _ in front} == set(first[:2])
    assert runs[: len(front)] == sorted(front, key=lambda run: (first.index(run[0]), run[1]))
    rest = [work for _, work in runs[len(front) :]]
    assert rest == sorted(rest, reverse=True)


DAY = 1440


def test_a_run_asks_for_more_than_it_takes_and_more_at_each_try():
    """At 1.1 million bead-steps per second, 312 MB for a million beads; up to a cluster's most."""
    for bead_steps in (1e5, 1e8, 1e10):
        asked = [minutes(bead_steps, attempt, DAY) for attempt in (1, 2, 3)]
        assert asked[0] * 60 > bead_steps / 1.1e6
        assert asked == [asked[0], 2 * asked[0], 3 * asked[0]]
    assert minutes(1e13, 1, DAY) == minutes(1e10, 100, DAY) == DAY
    assert megabytes(10**6, 1) > megabytes(192, 1) + 2 * 312
    assert megabytes(10**6, 3) == 3 * megabytes(10**6, 1)


def test_short_runs_share_a_job():
    """Each run once, in order; a long run alone; only those with the same start."""
    for name in ("equation_of_state_15", "chains", "tension"):
        sweep = read_paper("groot_warren_1997", "quick", only=[name]).sweeps[name]
        for seconds in (0, 20, 1e9):
            shared = batches(sweep, seconds)
            assert [point for each in shared for point in each] == list(sweep.points)
            for each in shared:
                took = sum(point.scene.work for point in each) / RATE
                assert len(each) == 1 or took <= seconds
                assert len({start_digest(p.scene) for p in each if start_is_shared(p.scene)}) < 2
    assert len(batches(sweep, 0)) == len(sweep.points)
