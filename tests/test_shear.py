"""Scenes with shear: bad input, files of tilted boxes, starts from sheared runs, viscosity."""

import numpy as np
import pytest
import xarray as xr

import dpd
from dpd.analysis.viscosity import viscosities, viscosity
from dpd.engine.crossings import crossing_bonds
from dpd.engine.simulation import Simulation
from dpd.engine.space import tilted
from dpd.errors import UserError
from dpd.particles import read, write
from dpd.physics.shear import Shear
from dpd.scene.scene import Scene
from dpd.start.common.files import read_start, write_start
from dpd.start.common.make import make_start, system_of
from tests.conftest import SCENE
from tests.engine.test_pairs import box_with
from tests.test_extend import assert_goes_on, run
from tests.test_particles import melt

FLUID = SCENE | {
    "box": [4.5, 4, 4],
    "shear": {"rate": 0.3},
    "steps": {"equilibrate": 20, "sample": 110},
    "observe": [
        {"thermo": {"every": 5}}, {"rdf": {"every": 10, "range": 2}}, {"profile": {"every": 10}},
        {"displacement": {"every": 5}}, {"configuration": {"every": 50}},
        {"trajectory": {"every": 5}},
    ],
}  # fmt: skip


def test_bonds_cross_at_the_images_that_have_slid():
    """Bond 0 goes up through a face; what is above it has slid by 1.8 r_c."""
    box = box_with((6.0, 5.0), Shear(0.1, 0, 1), 0.3)
    bonds = [
        [(2.0, 4.8), (0.2, 0.2)],
        [(1.8, 4.95), (2.2, 4.95)],  # below the face
        [(0.0, 0.1), (0.4, 0.1)],  # above it
        [(1.8, 0.1), (2.2, 0.1)],  # there if images had not slid
    ]
    position = np.array(bonds).reshape(-1, 2).T
    members = np.arange(8, dtype=np.uint32).reshape(-1, 2)
    found = crossing_bonds(np.ascontiguousarray(position), members, box)
    assert {tuple(pair) for pair in found.T.tolist()} == {(0, 1), (0, 2)}


def tilted_melt(dimension, turns):
    """Beads and bonds in a box whose images have slid."""
    plain = melt(dimension)
    return plain._replace(box=box_with(plain.box, Shear(0.1, 0, 1), turns))


def far(particles, tilt):
    """Positions with the images that beads have gone through."""
    moved = particles.image * np.array(particles.box)[:, None]
    moved[0] += tilt * moved[1]
    return particles.position + moved


@pytest.mark.parametrize("kind", ["gsd", "nc", "data"])
@pytest.mark.parametrize(("dimension", "turns"), [(2, -0.5), (3, 0.37)])
def test_tilted_boxes_there_and_back(tmp_path, dimension, turns, kind):
    """Beads come back where they were, in the box of right angles; GSD has boxes and tilts in
    single precision."""
    expected = tilted_melt(dimension, turns)
    write(expected, tmp_path / f"melt.{kind}")
    found = read(tmp_path / f"melt.{kind}")
    assert tuple(found.box) == tuple(expected.box)
    tilt, off = getattr(found.box, "tilt", 0.0), {"gsd": 1e-6}.get(kind, 1e-15)
    assert abs(tilt - expected.box.tilt) <= off
    assert (found.position >= 0).all() and (found.position < np.array(found.box)[:, None]).all()
    apart = far(found, tilt) - far(expected, expected.box.tilt)
    assert np.abs(apart).max() <= 30 * off
    np.testing.assert_array_equal(found.bonds, expected.bonds)
    np.testing.assert_array_equal(found.velocity, expected.velocity)


def test_other_programs_find_beads_in_the_tilted_box(tmp_path):
    """MDAnalysis reads the box of a GSD file; distances of beads are those of its images."""
    import gsd.hoomd
    from MDAnalysis.lib.distances import self_distance_array
    from MDAnalysis.lib.mdamath import triclinic_box

    particles = tilted_melt(3, 0.37)
    x, y, z = particles.box
    write(particles, tmp_path / "melt.gsd")
    with gsd.hoomd.open(tmp_path / "melt.gsd") as file:
        frame = file[0]
    place, (lx, ly, lz, xy, _, _) = frame.particles.position, frame.configuration.box
    dimensions = triclinic_box([lx, 0, 0], [xy * ly, ly, 0], [0, 0, lz])
    found = self_distance_array(place.astype(np.float32), box=dimensions)
    i, j = np.triu_indices(particles.beads, 1)
    images = np.array([[a, b, c] for a in range(-2, 3) for b in (-1, 0, 1) for c in (-1, 0, 1)])
    vectors = images @ np.array([[x, 0, 0], [0.37 * x, y, 0], [0, 0, z]])
    apart = (particles.position[:, i] - particles.position[:, j])[:, :, None] + vectors.T[:, None]
    expected = np.sqrt((apart**2).sum(axis=0)).min(axis=1)
    np.testing.assert_allclose(found, expected, atol=1e-4)


@pytest.fixture(scope="module")
def sheared(tmp_path_factory):
    """A run under shear that keeps its end, with images that have slid."""
    return Scene(FLUID), run(FLUID, tmp_path_factory.mktemp("sheared") / "run.nc")


def test_a_run_goes_on_from_the_end_of_a_sheared_one(sheared, tmp_path):
    """The same energy and conservative virial, also by a start that is kept in a file."""
    scene, path = sheared
    last = read(path)
    assert abs(last.box.tilt) > 0.1
    system = system_of(scene)
    now = tilted(system.box, system.shear, system.dt, 130)
    assert last.box.tilt == pytest.approx(now.tilt, abs=1e-15)
    other = Scene(FLUID | {"shear": {"rate": -0.1}, "start": {"method": "file", "path": str(path)}})
    state = make_start(other)
    assert state.slid is not None
    measured = dpd.load(path)
    begun = Simulation(system_of(other), state)
    energy = begun.measure().of(-1).energy[0]
    assert energy == pytest.approx(float(measured.pair_energy[-1]), rel=1e-12)
    write_start(other, tmp_path / "start.nc")
    again = read_start(other, tmp_path / "start.nc")
    assert again.slid == state.slid
    np.testing.assert_array_equal(
        Simulation(system_of(other), again).state.force, begun.state.force
    )
    assert read(tmp_path / "start.nc").box.tilt == pytest.approx(last.box.tilt, abs=1e-15)
    begun.advance(10)
    assert begun.box.tilt < last.box.tilt


def test_a_tilted_box_does_not_begin_a_scene_of_another_flow(sheared):
    """Nor one at rest."""
    change = {"shear": {"rate": 0.3, "gradient": "z"}, "start": {"method": "file"}}
    change["start"]["path"] = str(sheared[1])
    with pytest.raises(UserError, match=r"flow along x .*gradient along y.* no such shear"):
        make_start(Scene(FLUID | change))


def test_a_sheared_run_made_longer_is_one_that_was_planned_that_long(sheared, tmp_path):
    """Bit for bit, from a start whose images had slid before, with two threads."""
    start = {"start": {"method": "file", "path": str(sheared[1])}}
    longer = {"steps": {"equilibrate": 20, "sample": 200}, "seed": 4}
    assert_goes_on(tmp_path, FLUID | start | longer, 110, threads=2)


@pytest.fixture(scope="module")
def flows():
    """The standard fluid at two rates: 648 beads, 200 tau."""
    steps = {"equilibrate": 250, "sample": 5000}
    fluid = SCENE | {"box": 6, "steps": steps, "observe": [{"thermo": {"every": 2}}]}
    return {rate: dpd.run(fluid | {"shear": {"rate": rate}}) for rate in (0.5, -1.0)}


def test_viscosity_of_the_standard_fluid(flows):
    """About 0.85 at rho 3, a 25, gamma 4.5, a common value; within 0.04, our tolerance, and
    four standard errors, which are below 0.03. Two rates agree: the fluid is Newtonian."""
    slow, fast = (viscosity(run) for run in flows.values())
    for eta in (slow, fast):
        assert eta.error < 0.03
        assert abs(eta.value - 0.85) < 0.04 + 4 * eta.error
    assert abs(slow.value - fast.value) < 4 * np.hypot(slow.error, fast.error)


def test_stress_is_symmetric_and_heat_raises_kT(flows):
    """P_xy and P_yx have the same mean; the faster flow is the hotter one, by some per cent."""
    slow, fast = flows.values()
    tensor = fast.pressure_tensor_all.values.mean(axis=0)
    assert tensor[0, 1] == pytest.approx(tensor[1, 0], abs=0.01)
    assert 1.01 < float(slow.kT.mean()) < float(fast.kT.mean()) < 1.2


def test_viscosities_of_a_sweep(flows):
    """Replicas taken together; a run without shear is refused in a sentence."""
    slow = flows[0.5]
    scenes = np.array([[slow.attrs["scene"]] * 2])
    sweep = xr.Dataset(
        {
            "shear_stress": (("rate", "replica"), [[0.42, 0.44]], {"units": "kT / r_c^3"}),
            "shear_stress_error": (("rate", "replica"), [[0.01, 0.01]]),
            "scene": (("rate", "replica"), scenes),
        },
        {"rate": [0.5], "replica": [0, 1]},
    )
    found = viscosities(sweep)
    assert found.viscosity.dims == ("rate",)
    np.testing.assert_allclose(found.viscosity, [0.86])
    assert found.viscosity_error.item() > 0
    with pytest.raises(UserError, match="needs the key 'shear'"):
        viscosity(slow.drop_vars("shear_stress"))
