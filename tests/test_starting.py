"""Who makes a first configuration, and that it makes no difference."""

import time

import numpy as np
import pytest

from dpd import files
from dpd.runs.run import run, simulate
from dpd.scene.scene import Scene
from dpd.start.common.files import read_start, write_start
from dpd.start.common.make import make_start
from tests.conftest import SCENE

FLUID = SCENE | {
    "steps": {"equilibrate": 20, "sample": 180}, "start": {"relax": {"steps": 20, "dt": 0.01}},
}  # fmt: skip
MELT = {
    "dimension": 2, "box": 10, "molecules": [{"architecture": "A 10", "density": 2}],
    "bond": {"stiffness": 100, "length": 0.5}, "observe": [{"thermo": {"every": 100}}],
    "start": {"method": "polymerize", "polymerize": {"interval": 1e6}},
}  # fmt: skip


@pytest.mark.parametrize(
    ("change", "looks"),
    [({"box": 30, "start": {"relax": {"steps": 10**6, "dt": 0.01}}}, 2), (MELT, 3)],
)
def test_starts_can_be_ended_every_second_or_two(change, looks):
    """However long they are: a relaxation every few steps, growth within its rounds."""
    seen = []

    def look(done):
        seen.append(done)
        if len(seen) == looks:
            raise TimeoutError

    with pytest.raises(TimeoutError):
        make_start(Scene(FLUID | change), look)


def test_a_run_is_the_same_whoever_made_its_start(tmp_path):
    """The run, one before it in a job, or a file; what the run took counts its own start."""
    scene = Scene(FLUID)
    write_start(scene, tmp_path / "start.nc")
    begun = time.perf_counter() - 100  # as if its start had taken that long
    simulate(scene, tmp_path / "own.nc", make_start(scene), begun=begun)
    whole = time.perf_counter() - begun
    simulate(scene, tmp_path / "read.nc", read_start(scene, tmp_path / "start.nc"))
    (own, told), (read, _) = (files.read(tmp_path / name) for name in ("own.nc", "read.nc"))
    np.testing.assert_equal(read, own)
    for name, steps in (("before.nc", 20), ("after.nc", 180)):
        run(Scene(FLUID | {"steps": {"equilibrate": 20, "sample": steps}}), tmp_path / name)
    np.testing.assert_equal(files.read(tmp_path / "after.nc")[0], own)
    assert 100 < told["seconds"] < whole
