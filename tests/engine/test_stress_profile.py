"""The profile of the pressure tensor: where the virial and the kinetic part of a box lie."""

import numpy as np
import pytest

from dpd.engine.loop import run
from dpd.engine.state import State
from dpd.engine.stress import Slices, virial_in_slices
from dpd.scene.scene import Scene
from tests.engine.cases import CASES, stars
from tests.engine.cases import system_of as placed
from tests.engine.reference import Reference
from tests.systems import BOX_2D, BOX_3D, begun, by_identity, make_simulation, values_of

BOXES = pytest.mark.parametrize("box", [BOX_2D, BOX_3D], ids=["2D", "3D"])
SLAB = {
    "dimension": 3,
    "box": [4, 4, 8],
    "molecules": [{"architecture": "A 3", "count": 64}, {"architecture": "B", "count": 192}],
    "repulsion": {"A A": 25, "A B": 60, "B B": 25},
    "bond": {"stiffness": 30, "length": 0.6},
    "angle": {"stiffness": 5, "angle": 120},
    "mass": {"A": 1, "B": 2},
    "start": {"method": "slabs"},
    "integrator": {"scheme": "gw-vv", "dt": 0.02},
    "steps": {"equilibrate": 20, "sample": 40},
    "observe": [{"thermo": {"every": 4}}, {"stress_profile": {"every": 4, "bin": 0.3}}],
}
PLANE = SLAB | {
    "dimension": 2, "box": [6, 12],
    "molecules": [{"architecture": "A 3", "count": 36}, {"architecture": "B", "count": 108}],
}  # fmt: skip
WALLS = {"walls": {"axis": "z", "repulsion": {"A": 25, "B": 40}, "gamma": 3}}
PRESSED = {"pressure": {"target": 30, "time": 0.4}}


class StressedReference(Reference):
    """A `Reference` that keeps the line of every force, and what it adds to the virial."""

    def evaluate(self, velocity):
        """Forces as ever, with their lines."""
        self.lines = []
        super().evaluate(velocity)

    def add(self, i, j, r_ij, conservative, full):
        """A force on i from j; from r_i the line goes to r_i - r_ij."""
        super().add(i, j, r_ij, conservative, full)
        self.lines.append((self.position[:, i], r_ij, r_ij * conservative))

    def virial_in_slices(self, axis, edges):
        """(2, slices) array: along the axis, and the mean over the others."""
        found = np.zeros((2, len(edges) - 1))
        for begin, r_ij, virial in self.lines:
            shares = shares_of_slices(begin[axis], begin[axis] - r_ij[axis], edges)
            others = np.delete(virial, axis, axis=0).mean(axis=0)
            found += np.array([virial[axis], others]) @ shares
        return found


def shares_of_slices(begin, end, edges):
    """(lines, slices) array: the part of each line that lies in each slice, or an image of it."""
    low, high = np.minimum(begin, end)[:, None], np.maximum(begin, end)[:, None]
    length, period = high - low, edges[-1] - edges[0]
    shares = 0.0
    for image in (-period, 0.0, period):
        lower, upper = edges[:-1] + image, edges[1:] + image
        part = np.clip(np.minimum(high, upper) - np.maximum(low, lower), 0, None)
        inside = (low >= lower) & (low < upper)
        shares = shares + np.where(length > 1e-9, part / np.where(length > 0, length, 1), inside)
    return shares


def whole(virial):
    """Along an axis and the mean of the others, of a whole virial, for each axis."""
    diagonal = np.diag(virial)
    return [[part, np.delete(diagonal, k).mean()] for k, part in enumerate(diagonal)]


@pytest.mark.few("trees, 2D, tables", "many-body")
@pytest.mark.parametrize("name", ["trees", "trees, 2D, tables", "core", "many-body"])
def test_every_line_in_every_slice(name):
    """As in plain NumPy, also of beads on the edges of slices; all is in some slice."""
    system, position, _, species = placed(**CASES[name])
    identity = np.arange(position.shape[1], dtype=np.uint32)
    for axis, length in enumerate(system.box):
        for count in (1, 7, 40):
            place = position.copy()
            place[axis, ::6] = length / count * np.floor(place[axis, ::6] * count / length)
            state = State(place, place, None, identity, species, 0)
            there = StressedReference(system, "gw-vv", 0.5, place, 0 * place, species)
            found = virial_in_slices(system, state, Slices(axis, count, 0.0, length))
            expected = there.virial_in_slices(axis, np.linspace(0, length, count + 1))
            scale = sum(np.abs(virial).sum() for _, _, virial in there.lines)
            assert np.abs(found - expected).max() < 1e-9 * scale
            total = whole(there.virial[0])[axis]
            assert np.abs(found.sum(axis=1) - total).max() < 1e-12 * scale


@pytest.mark.few(1)
@BOXES
def test_normal_pressure_follows_from_forces(box):
    """Momentum is conserved: from place to place it changes by the forces on beads in between.

    This knows nothing of lines, so it tells whether angles are shared out rightly.
    """
    system, position, velocity = stars(box, True, friction=0.0)
    simulation = make_simulation(system, position, velocity)
    force, place = by_identity(simulation, "force"), by_identity(simulation, "position")
    for axis, length in enumerate(box):
        edges = np.linspace(0, length, 24)
        found, _ = virial_in_slices(system, simulation.state, Slices(axis, 23, 0.0, length))
        found *= 23 / length  # force through a plane, mean over a slice
        below = np.clip((edges[1:] - place[axis][:, None]) / (length / 23), 0, 1)
        expected = -force[axis] @ below
        np.testing.assert_allclose(
            found - found.mean(), expected - expected.mean(), atol=1e-10 * np.abs(force).max()
        )


def sampled(data, threads=1):
    """Observers of a short run, and the simulation."""
    simulation, observers, steps = begun(data, threads)
    run(simulation, steps, observers)
    return dict(zip(Scene(data).observe, map(values_of, observers))), simulation


@pytest.mark.few(1)
@pytest.mark.parametrize("base", [SLAB, PLANE], ids=["3D", "2D"])
@pytest.mark.parametrize(
    "more", [{}, {"walls": True}, PRESSED], ids=["periodic", "walls", "constant pressure"]
)
def test_each_sample_is_the_tensor_of_the_box(base, more):
    """Ten samples, of which each makes a block: their mean over slices is what thermo has."""
    if "walls" in more:
        more = {"walls": WALLS["walls"] | {"axis": "xyz"[base["dimension"] - 1]}}
    for axis in range(base["dimension"]):
        observe = [{"thermo": {"every": 4}},
                   {"stress_profile": {"every": 4, "bin": 0.3, "axis": "xyz"[axis]}}]  # fmt: skip
        found, simulation = sampled(base | more | {"observe": observe})
        profile = found["stress_profile"]
        tensors = found["thermo"]["pressure_tensor"]
        assert len(tensors) == 10 == len(profile["normal_pressure_profile"])
        expected = np.array([whole(tensor)[axis] for tensor in tensors])
        names = ("normal_pressure_profile", "tangential_pressure_profile")
        edge = simulation.system.extent[axis]
        for name, column in zip(names, expected.T):
            slices = profile["slice"]
            width = (slices[1] - slices[0]) if "pressure" not in more else edge / len(slices)
            np.testing.assert_allclose(
                profile[name].sum(axis=1) * width / edge, column, rtol=1e-11, err_msg=name
            )
