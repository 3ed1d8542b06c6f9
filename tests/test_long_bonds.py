"""Bonds longer than half the box: never a wrong number, and exact ones just below the limit."""

import numpy as np
import pytest

import dpd
from dpd.engine.space import nearest
from dpd.errors import UserError
from dpd.folders import PACKAGE
from dpd.observe.common.measured import reaching_over
from dpd.runs.run import Options, simulate
from dpd.scene.scene import Scene
from dpd.scene.yaml import read_yaml
from dpd.start.common.make import make_start
from tests.conftest import SCENE

DIMERS = SCENE | {
    "box": 3,
    "molecules": [{"architecture": "A 2", "count": 500}],
    "repulsion": {"A A": 0},
    "bond": {"stiffness": 2},
    "thermostat": {"kind": "langevin", "gamma": 4.5},
    "integrator": {"scheme": "gw-vv", "dt": 0.02},
    "steps": {"equilibrate": 200, "sample": 1000},
    "observe": [{"thermo": {"every": 10}}, {"bonds": {"every": 10}}],
}


@pytest.mark.few(1)
@pytest.mark.parametrize(
    "change",
    [{}, {"dimension": 2}, {"integrator": {"scheme": "aboba", "dt": 0.02}, "thermostat": {}}],
)  # fmt: skip
def test_a_run_whose_bonds_grow_too_long_ends_without_a_result(tmp_path, change):
    """It says at which step and what to do."""
    scene = Scene(DIMERS | change, "my.yaml")
    with pytest.raises(UserError) as caught:
        simulate(scene, tmp_path / "run.nc", make_start(scene), Options(every_seconds=60))
    for part in ("my.yaml: ", "by step", "48% of an edge", "larger box"):
        assert part in str(caught.value)
    assert not (tmp_path / "run.nc").exists()


def test_few_long_bonds_are_told_where_a_flow_draws_them():
    """Of a shear alone: at rest so few change no mean."""
    box = {"box": [12, 12, 12], "steps": {"equilibrate": 1000, "sample": 1000}, "seed": 1}
    flow = read_yaml(PACKAGE / "scenes" / "rest_after_shear.yaml") | box | {"schedule": []}
    with pytest.warns(UserWarning, match="over 48% of an edge, beyond .* the stress is too low"):
        dpd.run(flow, progress=False)


def test_what_is_counted():
    """Once for each axis, at nearest images."""
    box = (4.0, 6.0)
    position = np.array([[0.1, 2.0, 1.0, 3.1, 0.1, 3.9], [0.1, 0.1, 0.1, 2.8, 0.1, 0.1]])
    # Along x 1.9, 1, 1.9, 1, 0.2 (limit 1.92), along y 0, 0, 2.7, 2.7, 0 (limit 2.88).
    assert reaching_over(nearest(np.diff(position), box), box) == 0
    position[0, 1] = 2.05
    assert reaching_over(nearest(np.diff(position), box), box) == 1
    for y in (2.99, 3.11):  # before and after both flip
        position[1, 3] = y
        assert reaching_over(nearest(np.diff(position), box), box) == 3


BOX = 6.2  # about the smallest in which these dimers are short enough


def test_numbers_just_below_the_limit_are_exact():
    """<r^2> = 3 kT / C and an excess pressure of -n kT / V."""
    longer = {"box": BOX, "steps": {"equilibrate": 500, "sample": 8000}}
    run = dpd.run(DIMERS | longer, progress=False)
    for name, exact in (("bond_mean_square", 1.5), ("excess_conservative", -500 / BOX**3)):
        blocks = run[name].values.reshape(50, -1).mean(axis=1)
        error = blocks.std(ddof=1) / np.sqrt(50)
        assert abs(blocks.mean() - exact) < 4 * error < 0.02 * abs(exact)
