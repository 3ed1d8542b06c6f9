"""Surface tension from the tensor and from the profile, and what has to hold for it."""

import json

import numpy as np
import pytest
import xarray as xr

import dpd
from dpd.analysis.interfaces import slab_tension, tension_of_tensor
from dpd.analysis.statistics import block_mean_and_error
from dpd.errors import UserError
from dpd.scene.scene import Scene
from tests.test_interfaces import profile

SLABS = {
    "dimension": 3,
    "box": [5, 5, 16],
    "molecules": [{"architecture": "A", "density": 1.5}, {"architecture": "B", "density": 1.5}],
    "repulsion": {"A A": 25, "A B": 45, "B B": 25},
    "start": {"method": "slabs"},
    "integrator": {"scheme": "gw-vv", "dt": 0.04},
    "steps": {"equilibrate": 1000, "sample": 8000},  # 2000 samples, 40 in each block
    "observe": [
        {"thermo": {"every": 4}}, {"profile": {"every": 10}},
        {"stress_profile": {"every": 4, "bin": 0.25}},
    ],
}  # fmt: skip
ONE = {"molecules": [{"architecture": "A", "density": 3}], "repulsion": {"A A": 25}}


@pytest.fixture(scope="module")
def slab_run():
    """Two slabs that hardly mix."""
    return dpd.run(SLABS, progress=False)


def test_tensor_and_profile_agree(slab_run):
    """To rounding, as they look at the same samples; and the bulks are isotropic."""
    found = slab_tension(slab_run)
    of_tensor, of_profile = found.of_tensor, found.of_profile
    assert found.best == of_tensor == tension_of_tensor(slab_run)
    assert of_profile.value == pytest.approx(of_tensor.value, rel=1e-10)
    assert of_profile.error == pytest.approx(of_tensor.error, rel=0.5)
    # Groot and Warren 1997 fit their single beads of density 3, chi = 0.286 * 20, by this.
    chi = 0.286 * 20
    published = 0.75 * 3 * chi**0.26 * (1 - 2.36 / chi) ** 1.5
    assert abs(of_tensor.value - published) < 4 * of_tensor.error
    assert of_tensor.error < 0.1 * of_tensor.value
    for part in found.bulks:
        assert 0 < part.error < 0.2
        assert abs(part.value) < 4 * part.error
    mean, error = block_mean_and_error(slab_run.normal_pressure_profile.values)
    assert np.abs(mean - mean.mean()).max() < 5 * error.max()  # the same everywhere
    tangential, _ = block_mean_and_error(slab_run.tangential_pressure_profile.values)
    assert np.abs(tangential - mean.mean()).max() > 10 * error.max()


def made_up(missing=(0.0, 0.0), drift=0.0, **changes):
    """A run with a given p_N - p_T at interfaces and in bulks, and slabs whose minority grows."""
    data = SLABS | {"box": [5, 5, 20]} | changes
    scene = Scene(
        data | {"observe": [{"profile": {"every": 10}}, {"stress_profile": {"bin": 0.5}}]}
    )
    rng, place = np.random.default_rng(3), (np.arange(40) + 0.5) * 0.5
    near = np.minimum(np.abs((place + 10) % 20 - 10), np.abs(place - 10)) < 1.5
    normal = np.where(near, *missing) + rng.normal(0, 1e-3, (50, 40))
    density = [profile(0, 10, 1.5, 0.02 + drift * n, 4000, n) for n in range(50)]
    return xr.Dataset(
        {
            "density_profile": (("block", "species", "z"), density),
            "normal_pressure_profile": (("block", "slice"), 20 + normal),
            "tangential_pressure_profile": (("block", "slice"), np.full((50, 40), 20.0)),
        },
        {"z": (np.arange(100) + 0.5) * 0.2, "slice": place},
        {"scene": json.dumps(scene.data)},
    )


def test_profile_and_bulks_of_what_was_made_up():
    """Tension 1.2 from 6 r_c with 0.4; bulks that are off, and slabs that dissolve, are seen."""
    found = slab_tension(made_up((0.4, 0.0)))
    assert found.of_profile.value == pytest.approx(0.4 * 6 / 2, abs=4e-3)
    assert max(abs(part.value) for part in found.bulks) < 1e-3
    off, dissolving = slab_tension(made_up((0.4, 0.1))), slab_tension(made_up(drift=5e-4))
    assert all(part.value == pytest.approx(0.1, abs=1e-3) for part in off.bulks)
    assert found.settled and not dissolving.settled


def test_a_box_that_is_stretched():
    """At constant pressure each sample has the length that belongs to it."""
    settings = {"pressure": {"target": 23, "axes": "z", "time": 1}}
    data = SLABS | settings | {"steps": {"equilibrate": 20, "sample": 200}}
    run = dpd.run(data | {"observe": [{"thermo": {"every": 4}}]}, progress=False)
    tensor = run.pressure_tensor.values
    missing = tensor[:, 2, 2] - (tensor[:, 0, 0] + tensor[:, 1, 1]) / 2
    expected = (run.volume.values / 25 * missing).mean() / 2
    assert tension_of_tensor(run, axis="z").value == pytest.approx(expected, rel=1e-12)
    assert np.ptp(run.volume.values) > 1


def test_what_is_missing_is_said():
    """Observables, walls, species, axes."""
    run = made_up()
    with pytest.raises(UserError, match="no pressure tensor was measured"):
        tension_of_tensor(run)
    with pytest.raises(UserError, match="observe 'stress_profile'"):
        slab_tension(run.drop_vars("normal_pressure_profile"))
    with pytest.raises(UserError, match="1 species"):
        slab_tension(made_up(**ONE))
    with pytest.raises(UserError, match="without walls"):
        slab_tension(made_up(walls={"axis": "z", "repulsion": 25}))
