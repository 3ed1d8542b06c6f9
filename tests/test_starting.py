"""Who makes a first configuration, and that it makes no difference."""

import time

import numpy as np
import pytest

from dpd import files
from dpd.runs.run import simulate
from dpd.scene.scene import Scene
from dpd.scene.yaml import merge
from dpd.start import start_is_shared
from dpd.start.common.files import read_start, write_start
from dpd.start.common.make import make_start

FLUID = {
    "dimension": 3,
    "box": 4,
    "molecules": [{"architecture": "A", "density": 3}],
    "repulsion": {"A A": 25},
    "thermostat": {"kT": 1, "gamma": 4.5, "noise": "uniform"},
    "integrator": {"scheme": "gw-vv", "dt": 0.04},
    "steps": {"equilibrate": 20, "sample": 180},
    "start": {"relax": {"steps": 20, "dt": 0.01}},
}


@pytest.mark.parametrize(
    "change, shared",
    [
        ({}, False),
        ({"start": {"relax": {"steps": 21}}}, True),
        ({"steps": {"sample": 179}}, True),
        ({"start": {"method": "slabs"}}, False),
    ],
)
def test_a_short_relaxation_is_part_of_the_run(change, shared):
    """Up to a tenth of the run's steps: longer ones have a job and a file of their own."""
    assert start_is_shared(Scene(merge(FLUID, change))) is shared


def test_grown_chains_have_a_file_however_long_the_run():
    """Placed ones have none."""
    chains = {"dimension": 2, "box": 20, "molecules": [{"architecture": "A 10", "count": 40}]}
    bonds = {"bond": {"stiffness": 100, "length": 0.5}, "steps": {"sample": 10**8}}
    chains["observe"] = [{"thermo": {"every": 100}}]
    data = {key: value for key, value in FLUID.items() if key != "start"} | chains
    placed = Scene(merge(data, bonds))
    grown = Scene(merge(data, bonds | {"start": {"method": "polymerize"}}))
    assert not start_is_shared(placed) and start_is_shared(grown)


class Enough(Exception):
    """What ends a start from outside."""


def ended_after(looks, scene):
    """What a start said at each look until it was ended."""
    seen = []

    def look(done):
        seen.append(done)
        if len(seen) == looks:
            raise Enough

    with pytest.raises(Enough):
        make_start(scene, look)
    return seen


def test_starts_can_be_ended_every_second_or_two():
    """A relaxation every few steps, fewer in a large system; growth between its rounds.

    However long these are: here 5e8 steps each.
    """
    scene = Scene(merge(FLUID, {"box": 30, "start": {"relax": {"steps": 10**6}}}))
    assert ended_after(2, scene) == [246, 492]
    melt = {
        "dimension": 2, "box": 10, "molecules": [{"architecture": "A 10", "count": 10}],
        "bond": {"stiffness": 100, "length": 0.5},
        "start": {"method": "polymerize", "polymerize": {"interval": 1e6}},
    }  # fmt: skip
    assert len(ended_after(50, Scene(FLUID | melt))) == 50


def test_a_run_is_the_same_whoever_made_its_start(tmp_path):
    """Made by the run or read from a file; what the run took counts its own start."""
    scene = Scene(FLUID)
    write_start(scene, tmp_path / "start.nc")
    begun = time.perf_counter() - 100  # as if its start had taken that long
    simulate(scene, tmp_path / "own.nc", make_start(scene), begun=begun)
    whole = time.perf_counter() - begun
    simulate(scene, tmp_path / "read.nc", read_start(scene, tmp_path / "start.nc"))
    (own, told), (read, _) = (files.read(tmp_path / name) for name in ("own.nc", "read.nc"))
    assert read.keys() == own.keys()
    for name, values in own.items():
        assert np.array_equal(values, read[name]), name
    assert 100 < told["seconds"] < whole
