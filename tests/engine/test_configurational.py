"""A temperature from positions alone."""

import numpy as np
import pytest

from dpd.engine.queries.stress import force_and_curvature
from dpd.physics.repulsion import Soft
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of
from tests.systems import chains, make_simulation, make_system, random_beads

BOX = {2: (3.1, 2.5), 3: (2.5, 3.7, 4.0)}
NUDGE = 1e-5  # r_c


def potential(position, species, repulsion, bonds, box):
    """Every pair, and every bond, at its nearest image."""
    edges = np.array(box)[:, None]

    def distance(i, j):
        apart = position[:, i] - position[:, j]
        return np.sqrt(((apart - edges * np.round(apart / edges)) ** 2).sum(axis=0))

    i, j = np.triu_indices(position.shape[1], 1)
    w = np.maximum(0, 1 - distance(i, j))
    members, stiffness, length = bonds
    stretch = distance(*members.T) - length
    pairs = 0.5 * repulsion[species[i], species[j]] * w**2
    return pairs.sum() + 0.5 * stiffness * (stretch**2).sum()


@pytest.mark.few(1)
@pytest.mark.parametrize("dimension", [3, 2])
def test_sums_are_derivatives_of_the_potential(dimension):
    """Slope and curvature of the energy along every coordinate, by small steps."""
    box, table = BOX[dimension], np.array([[25.0, 40.0], [40.0, 30.0]])
    position, _ = random_beads(box, 24, seed=7)
    species = (np.arange(24) % 2).astype(np.uint8)
    bonds = (chains(4, 4), 60.0, 0.7)
    square = curvature = 0.0
    for k in range(dimension):
        for i in range(24):
            energies = []
            for step in (-NUDGE, 0.0, NUDGE):
                moved = position.copy()
                moved[k, i] += step
                energies.append(potential(moved, species, table, bonds, box))
            square += ((energies[2] - energies[0]) / (2 * NUDGE)) ** 2
            curvature += (energies[2] - 2 * energies[1] + energies[0]) / NUDGE**2
    system = make_system(box, repulsion=table, bonds=bonds)
    found = force_and_curvature(system, make_simulation(system, position, position, species).state)
    np.testing.assert_allclose(found, [square, curvature], rtol=1e-4)


def test_it_is_the_temperature_in_equilibrium():
    """kT 1 within four standard errors, where a small step has brought the fluid."""
    position, velocity = random_beads((5.0,) * 3, 375)
    system = make_system((5.0,) * 3, dt=0.01)
    simulation = make_simulation(system, position, velocity)
    simulation.advance(3000)  # the heat of beads put anywhere leaves within some 10 tau
    rows = []
    for _ in range(400):
        simulation.advance(20)
        rows.append(force_and_curvature(system, simulation.state))
    blocks = np.array(rows).reshape(20, 20, 2).mean(axis=1)
    mean = blocks.mean(axis=0)
    spread = (blocks[:, 0] - mean[0] / mean[1] * blocks[:, 1]).std(ddof=1) / np.sqrt(20) / mean[1]
    assert abs(mean[0] / mean[1] - 1) < 4 * spread < 0.05


@pytest.mark.thorough
def test_a_scene_may_ask_for_it(tmp_path):
    """Its blocks stand in the file; with a rigid core it is refused."""
    import netCDF4

    from dpd.errors import UserError
    from dpd.runs.run import simulate

    scene = {
        "dimension": 2, "box": 6, "molecules": [{"architecture": "A 4", "density": 2}],
        "repulsion": {"A A": 25}, "bond": {"stiffness": 20, "length": 0.5},
        "integrator": {"scheme": "gw-vv", "dt": 0.02}, "steps": {"equilibrate": 50, "sample": 400},
        "observe": ["thermo", {"configurational": {"every": 20}}],
    }  # fmt: skip
    good = Scene(scene)
    simulate(good, tmp_path / "run.nc", make_start(good))
    with netCDF4.Dataset(tmp_path / "run.nc") as file:
        ratio = file["force_square"][:].mean() / file["curvature"][:].mean()
    assert 0.5 < ratio < 2.0
    assert isinstance(system_of(good).pair, Soft)
    with pytest.raises(UserError, match="configurational"):
        Scene(scene | {"core": {"radius": 0.15, "force": 100}})
