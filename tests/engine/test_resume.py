"""An interrupted run goes on to the same bits as one that was left alone."""

import numpy as np
import pytest

from dpd.engine.loop import Checkpoint, run
from tests.systems import assert_same_state, begun

SCENE = {
    "dimension": 2,
    "box": [4.0, 5.5],
    "molecules": [{"architecture": "A 3 B", "count": 10}, {"architecture": "B", "count": 15}],
    "repulsion": {"A A": 25, "A B": 40, "B B": 30},
    "bond": {"stiffness": 20, "length": 0.4},
    "integrator": {"scheme": "gw-vv", "dt": 0.03},
    "steps": {"equilibrate": 1020, "sample": 200},
    "observe": [
        {"thermo": {"every": 5}},
        {"rdf": {"every": 10, "range": 2}},
        {"profile": {"every": 20}},
        {"bonds": {"every": 20}},
    ],
}
LAST = 1220
KEY = {"scene": "this", "sources": "these"}


class Interrupted(Exception):
    """What stops a run from outside."""


def stop_at(last):
    """Progress that interrupts the run once it has come to a step."""

    def progress(step):
        if step >= last:
            raise Interrupted

    return progress


def interrupted_run(checkpoint, last):
    """Run from the start until interrupted, saving after every stretch of steps."""
    simulation, observers, steps = begun(SCENE)
    with pytest.raises(Interrupted):
        run(simulation, steps, observers, checkpoint, stop_at(last), every_seconds=0.0)


def assert_same_run(one, other):
    """State and all that was observed agree bit for bit."""
    assert_same_state(one[0].state, other[0].state)
    for a, b in zip(one[1], other[1]):
        assert a.arrays.keys() == b.arrays.keys()
        for name, array in a.arrays.items():
            np.testing.assert_array_equal(array, b.arrays[name], err_msg=name)


@pytest.fixture(scope="module")
def whole():
    """A run that nothing interrupts."""
    simulation, observers, steps = begun(SCENE)
    assert run(simulation, steps, observers) == LAST
    return simulation, observers


@pytest.mark.parametrize(
    "last, saved",
    [(1000, 500), (1025, 1000), (1115, 1110), (LAST, 1210)],
    ids=["equilibrating", "at the first sample", "sampling", "after the last sample"],
)
def test_interrupted_run_goes_on_to_the_same_bits(whole, tmp_path, last, saved):
    """Whatever came after the last checkpoint is done again, and no more than that."""
    checkpoint = Checkpoint(tmp_path / "run.checkpoint", KEY)
    interrupted_run(checkpoint, last)
    simulation, observers, steps = begun(SCENE)
    assert run(simulation, steps, observers, checkpoint) == LAST - saved
    assert_same_run((simulation, observers), whole)


LIQUID = SCENE | {
    "dimension": 3,
    "box": [4.0, 5.0, 4.5],
    "molecules": [{"architecture": "A 3 B", "count": 40}, {"architecture": "B", "count": 80}],
    "steps": {"equilibrate": 20, "sample": 60},
    "observe": [{name: {"every": 5}} for name in ("thermo", "chains", "end_to_end", "trace")],
}
STRESS = {"observe": [{"thermo": {"every": 4}}, {"stress_profile": {"every": 4, "bin": 0.3}}]}
KINDS = {
    "core, list": {"core": {"radius": 0.15, "force": 100}, "pairs": {"search": "list"},
                   "start": {"relax": {"steps": 200, "dt": 0.001}},
                   "integrator": {"scheme": "gw-vv", "dt": 0.002}},
    "dpd-vv, list": {"integrator": {"scheme": "dpd-vv", "dt": 0.005}, "pairs": {"search": "list"}},
    "frictions and masses": {"integrator": {"scheme": "dpd-vv", "dt": 0.01},
                             "thermostat": {"gamma": {"A A": 4.5, "A B": 12, "B B": 0.5}},
                             "mass": {"A": 0.5, "B": 3}},
    "shear": {"integrator": {"scheme": "dpd-vv", "dt": 0.03}, "shear": {"rate": 0.4},
              "observe": [{"displacement": {"every": 5}}, {"profile": {"every": 20}}]},
    "trees": {"molecules": [{"architecture": "A 3 (B 2) A 3", "count": 30}],
              "angle": {"A A A": {"stiffness": 5}, "B A A": {"stiffness": 4, "angle": 90},
                        "A B B": {"stiffness": 3, "angle": 120}},
              "observe": [{name: {"every": 5}} for name in ("thermo", "chains", "trace")]},
    "pressure": {"pressure": {"target": 30, "time": 0.4}} | STRESS,
    "walls": {"walls": {"axis": "z", "repulsion": {"A": 25, "B": 40}, "gamma": 3}} | STRESS,
}  # fmt: skip


@pytest.mark.few("dpd-vv, list", "pressure")
@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_run_goes_on_to_the_same_bits(tmp_path, kind):
    """Interrupted with two threads, and going on with three."""
    checkpoint = Checkpoint(tmp_path / "run.checkpoint", KEY)
    whole, broken, again = (begun(LIQUID | KINDS[kind], threads) for threads in (1, 2, 3))
    run(whole[0], whole[2], whole[1])
    with pytest.raises(Interrupted):
        run(broken[0], broken[2], broken[1], checkpoint, stop_at(50), every_seconds=0.0)
    assert 0 < run(again[0], again[2], again[1], checkpoint) <= 35
    assert_same_run(again, whole)
