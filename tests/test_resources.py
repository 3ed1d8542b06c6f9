"""What jobs ask a cluster for."""

import pytest

from dpd.errors import UserError
from dpd.pipeline.jobs import GROUPS, RATE, batches, group, megabytes, minutes, start_bead_steps
from dpd.pipeline.paper import read_config, read_paper
from dpd.scene.scene import Scene
from dpd.start import start_digest, start_is_shared
from tests.conftest import SCENE

DAY = 1440


def test_a_run_asks_for_more_than_it_takes_and_more_at_each_try():
    """At the speed of the slowest run of the quick study, 1.1 million bead-steps per second."""
    for bead_steps in (1e5, 1e8, 1e10):
        asked = [minutes(bead_steps, attempt, DAY) for attempt in (1, 2, 3)]
        assert asked[0] * 60 > bead_steps / 1.1e6
        assert asked == [asked[0], 2 * asked[0], 3 * asked[0]]


def test_nothing_asks_for_more_than_a_cluster_allows():
    """A run that needs more goes on in its next try."""
    assert minutes(1e13, 1, DAY) == minutes(1e10, 100, DAY) == DAY


def test_memory_grows_with_beads_and_tries():
    """A million beads take 312 MB."""
    assert megabytes(192, 1) < 1100
    assert megabytes(10**6, 1) > megabytes(192, 1) + 2 * 312
    assert megabytes(10**6, 3) == 3 * megabytes(10**6, 1)


def test_short_runs_share_a_submission():
    """By the minutes that they are expected to take; long ones have their own."""
    assert [group(bead_steps) for bead_steps in (0, 1e8, 1e9, 1e10)] == [
        "short", "short", "medium", None,
    ]  # fmt: skip
    assert list(GROUPS) == ["short", "medium"]  # profiles/slurm/config.yaml names them


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


def test_work_of_a_start():
    """Beads that are only placed are none; steps of relaxation count."""
    assert start_bead_steps(Scene(SCENE)) == 0
    relaxed = Scene(SCENE | {"start": {"relax": {"steps": 10, "dt": 0.01}}})
    assert start_bead_steps(relaxed) == 10 * relaxed.beads
    sweep = read_paper("liu_2008", "smoke", only=["melts"]).sweeps["melts"]
    assert start_bead_steps(sweep.points[0].scene) > 10_000 * sweep.points[0].scene.beads


def test_the_longest_job_of_a_cluster():
    """It has a default, and is refused if it is no number of minutes."""
    assert read_config()["longest_job"] == DAY
    assert read_config({"longest_job": 120})["longest_job"] == 120
    for wrong in ("2h", 3, None):
        with pytest.raises(UserError, match="longest_job"):
            read_config({"longest_job": wrong})
