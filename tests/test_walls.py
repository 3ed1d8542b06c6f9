"""Scenes with walls and body forces: what they may say, where beads begin, what is observed."""

import gsd.hoomd
import numpy as np
import pytest

from dpd import files
from dpd.engine.simulation import Snapshot
from dpd.engine.space import nearest
from dpd.engine.state import State, Sums
from dpd.errors import UserError
from dpd.observe.common.measured import observables
from dpd.particles import read, write
from dpd.runs.run import simulate
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of
from tests.conftest import SCENE
from tests.systems import begun, values_of
from tests.test_extend import run

CHANNEL = {
    "dimension": 3,
    "box": [3, 4, 5],
    "molecules": [{"architecture": "A 3 B", "density": 2}, {"architecture": "B", "density": 1}],
    "repulsion": {"A A": 25, "A B": 30, "B B": 25},
    "bond": {"stiffness": 20, "length": 0.5},
    "walls": {"axis": "z", "repulsion": {"A": 25, "B": 40}, "gamma": 9},
    "integrator": {"scheme": "gw-vv", "dt": 0.02},
    "steps": {"equilibrate": 20, "sample": 100},
    "observe": ["thermo", {"walls": {"every": 10}}, {"velocity_profile": {"every": 10}},
                {"profile": {"every": 10}}, {"trajectory": {"every": 10}}],
}  # fmt: skip
FLUID = SCENE | {"box": 5, "steps": {"sample": 100}, "observe": ["thermo"]}
WALLS = {"axis": "z", "repulsion": 25}
ROUGH = WALLS | {"gamma": 9}


def test_the_period_is_longer_where_there_are_walls():
    """And by nothing elsewhere; density and volume are those between the planes."""
    scene = Scene(CHANNEL)
    system = system_of(scene)
    assert (scene.period, scene.origin) == ((3.0, 4.0, 9.0), (0.0, 0.0, 2.0))
    assert (system.box, system.extent, system.origin) == ((3, 4, 9), (3, 4, 5), (0, 0, 2))
    assert system.volume == scene.volume == 60.0


@pytest.mark.parametrize(("method", "axis"), [("random", "z"), ("slabs", ["x", "z"])])
def test_beads_begin_between_the_planes(method, axis):
    """Also those of chains, whose bonds keep their lengths or are folded back."""
    scene = Scene(CHANNEL | {
        "start": {"method": method}, "walls": CHANNEL["walls"] | {"axis": axis}
    })  # fmt: skip
    state, (one, other) = make_start(scene), scene.bonded.T
    place = state.position - np.array(scene.origin)[:, None]
    assert place.min() >= 0 and (place.max(axis=1) <= scene.box).all()
    apart = nearest(state.position[:, one] - state.position[:, other], scene.period)
    assert np.linalg.norm(apart, axis=0).max() < 0.5 + 1e-9


@pytest.fixture(scope="module")
def channel(tmp_path_factory):
    """A run between walls, with a trajectory."""
    return run(CHANNEL, tmp_path_factory.mktemp("channel") / "run.nc")


def test_files_have_the_longer_box(channel):
    """So no bead behind a plane appears at the other end: in the result and in GSD."""
    last = read(channel)
    assert last.box == (3.0, 4.0, 9.0)
    place = last.position[2] - 2.0
    assert -1 < place.min() < 1 and 4 < place.max() < 6
    with gsd.hoomd.open(channel.with_suffix(".gsd")) as frames:
        for frame in frames:
            np.testing.assert_allclose(frame.configuration.box[:3], [3, 4, 9])
            assert np.abs(frame.particles.position[:, 2]).max() < 3.5
            assert not frame.particles.image[:, 2].any()


def test_a_run_goes_on_from_another(channel, tmp_path):
    """From its own file beads are where they were; so from one whose box ends at the planes."""
    scene = Scene(CHANNEL | {"start": {"method": "file", "path": str(channel)}})
    last = read(channel)
    np.testing.assert_array_equal(make_start(scene).position, last.position)
    place = np.clip(last.position[2] - 2.0, 0, 5 - 1e-9)
    tight = last._replace(
        box=(3.0, 4.0, 5.0), position=np.stack([*last.position[:2], place]),
        image=np.zeros_like(last.image),
    )  # fmt: skip
    write(tight, tmp_path / "tight.nc")
    scene = Scene(CHANNEL | {"start": {"method": "file", "path": str(tmp_path / "tight.nc")}})
    np.testing.assert_allclose(make_start(scene).position[2], place + 2.0, atol=1e-12)


def test_a_file_of_another_box(channel, tmp_path):
    """Refused, as are bonds through the face where a wall is to stand."""
    last = read(channel)
    data = CHANNEL | {"start": {"method": "file", "path": str(tmp_path / "other.nc")}}
    for box, words in (((3.0, 4.0, 4.9), "its box is .*4.9"), ((3.0, 4.0, 5.0), "through the fa")):
        position = np.random.default_rng(1).random(last.position.shape) * np.array(box)[:, None]
        other = last._replace(box=box, position=position, image=0 * last.image)
        write(other, tmp_path / "other.nc")
        with pytest.raises(UserError, match=words):
            make_start(Scene(data))


def test_what_a_run_between_walls_holds(channel):
    """All beads are in both profiles; energies add up; a series for each wall."""
    values, _ = files.read(channel)
    scene = Scene(CHANNEL)
    assert list(values["wall"]) == ["z lower", "z upper"]
    assert values["wall_pressure"].shape == (10, 2) and (values["wall_pressure"] > 0).all()
    assert values["wall_friction"].shape == (10, 2, 3)
    for name in ("z", "layer"):
        assert values[name][0] < -0.5 and values[name][-1] > 5.5
    layer = 12.0 * (values["layer"][1] - values["layer"][0])
    beads = np.nansum(values["bead_profile"], axis=1) * layer
    np.testing.assert_allclose(beads, scene.beads)
    np.testing.assert_allclose(values["density_profile"].sum(axis=(1, 2)) * layer, scene.beads)
    beyond = np.abs(values["layer"] - 2.5) > 2.5 + layer / 24  # the whole layer behind a plane
    assert beyond.any() and not np.nansum(values["bead_profile"][:, beyond])
    kinetic = 1.5 * scene.beads * values["kT"]
    parts = values["pair_energy"] + values["bond_energy"] + values["wall_energy"]
    np.testing.assert_allclose(values["total_energy"], kinetic + parts)


def test_a_run_that_gets_behind_a_wall(tmp_path):
    """It fails with bead, step and remedy, or its result records where it was lost."""
    hot = FLUID | {
        "walls": WALLS, "start": {"kT": 200}, "thermostat": {"gamma": 0},
        "integrator": {"scheme": "gw-vv", "dt": 0.005},
    }  # fmt: skip
    scene = Scene(hot, "hot.yaml")
    with pytest.raises(UserError, match=r"hot.yaml: bead \d+ got .* behind a wall at step") as said:
        simulate(scene, tmp_path / "run.nc", make_start(scene))
    assert "raise walls.repulsion" in str(said.value)
    scene = Scene(hot | {"unstable": "record"})
    simulate(scene, tmp_path / "run.nc", make_start(scene))
    assert 0 < files.attributes(tmp_path / "run.nc")["lost_step"] < 100


def test_temperature_is_measured_about_the_flow():
    """Of beads with u = z / 2 and a scatter of 0.9 about it: 0.81 in every layer."""
    velocity_profile = {"velocity_profile": {"axis": "z", "bin": 1, "every": 1}}
    simulation, (observer,), _ = begun(FLUID | {"observe": [velocity_profile]})
    rng = np.random.default_rng(3)
    for _ in range(100):
        position = rng.random((3, 4000)) * 5
        velocity = 0.9 * rng.normal(size=(3, 4000))
        velocity[0] += 0.5 * np.floor(position[2])
        state = State(position, velocity, None, None, None, 0)
        observer.sample(Snapshot(simulation.system, state))
    found = values_of(observer)
    np.testing.assert_allclose(found["layer"], [0.5, 1.5, 2.5, 3.5, 4.5])
    flow = found["velocity_profile"].mean(axis=0)
    np.testing.assert_allclose(flow[0], [0, 0.5, 1, 1.5, 2], atol=0.02)
    np.testing.assert_allclose(flow[1:], 0, atol=0.02)
    np.testing.assert_allclose(found["temperature_profile"].mean(axis=0), 0.81, atol=0.01)
    np.testing.assert_allclose(found["bead_profile"].mean(axis=0), 4000 / 125, rtol=0.02)


def test_a_wall_feels_the_opposite_of_what_it_does():
    """Per area: pressure outwards, and the friction of the beads with it."""
    scene = Scene(FLUID | {"walls": ROUGH, "observe": [{"walls": {"every": 1}}]})
    on_beads = np.array([[[1.0, 50.0, 2.5, 0.0, 5.0], [1.0, 75.0, -2.5, 1.0, 0.0]]])
    (walls,) = observables(scene, system_of(scene))
    walls.record(Sums(step=np.ones(1, int), volume=None, beads=None, moments=None, walls=on_beads))
    pressure, friction = (walls.variables()[f"wall_{name}"][1] for name in ("pressure", "friction"))
    np.testing.assert_allclose(pressure[0], [2, 3])
    np.testing.assert_allclose(friction[0], [[-0.1, 0, -0.2], [0.1, -0.04, 0]], atol=1e-15)
