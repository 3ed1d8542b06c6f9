"""What jobs ask a cluster for, and which runs share one."""

from dpd.pipeline.jobs import RATE, batches, megabytes, minutes, quickest
from dpd.pipeline.paper import read_paper
from dpd.scene.scene import Scene
from tests.conftest import SCENE

DAY = 1440


def test_a_job_asks_for_more_than_it_takes_and_more_at_each_try():
    """At 1.1 million bead-steps per second, 312 MB for a million beads; up to a cluster's most."""
    for steps in (10**3, 10**6, 10**8):
        scene = Scene(SCENE | {"steps": {"sample": steps}, "observe": []})
        asked = [minutes([scene], attempt, DAY) for attempt in (1, 2, 3)]
        assert asked[0] * 60 > min(scene.work / 1.1e6, DAY * 60 - 1)
        assert asked == [min(times * asked[0], DAY) for times in (1, 2, 3)]
    relaxed = Scene(SCENE | {"start": {"relax": {"steps": 10**6, "dt": 0.01}}})
    assert minutes([relaxed], 1, DAY) * 60 > relaxed.beads
    small, large = (Scene(SCENE | {"box": box}) for box in (4, 60))
    grown = 312 * (large.beads - small.beads) / 1e6
    assert megabytes([small, large], 1) > megabytes([small], 1) + 2 * grown
    assert megabytes([large], 3) == 3 * megabytes([large], 1)


def test_short_runs_share_a_job():
    """Each run once, in order; a long run alone."""
    for name in ("equation_of_state_15", "chains", "tension"):
        sweep = read_paper("groot_warren_1997", "quick", only=[name]).sweeps[name]
        for seconds in (0, 20, 1e9):
            shared = batches(sweep, seconds)
            assert [point for each in shared for point in each] == list(sweep.points)
            for each in shared:
                took = sum(point.scene.work for point in each) / RATE
                assert len(each) == 1 or took <= seconds
    assert len(batches(sweep, 0)) == len(sweep.points)


def test_the_figure_of_least_work_is_drawn_first():
    """Of those that are simulated: the first to look at, while the others wait."""
    paper = read_paper("groot_warren_1997", "quick")
    sweeps = {name: sum(p.scene.work for p in each.points) for name, each in paper.sweeps.items()}
    work = sum(sweeps[name] for name in quickest(paper))
    others = (sum(map(sweeps.get, figure.sweeps)) for figure in paper.figures.values())
    assert work == min(filter(None, others))
