"""Rings and networks: how they are written, read from files, placed, and how large they are."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given

import dpd
from dpd.engine.simulation import Simulation
from dpd.engine.state import OF_BONDS
from dpd.errors import UserError
from dpd.folders import PACKAGE
from dpd.particles import read, write
from dpd.particles.particles import Particles, spanned
from dpd.scene.molecules import graph_of, written
from dpd.scene.scene import Scene
from dpd.scene.yaml import merge, read_yaml
from dpd.start.common.make import make_start, system_of
from tests.conftest import SCENE
from tests.systems import look
from tests.test_trees import WRITTEN

RINGS = read_yaml(PACKAGE / "scenes" / "rings.yaml")


def test_rings_are_written():
    """An o closes a group, whatever hangs on it; copies are closed too; nothing shorter is one."""
    assert graph_of("(A 3)o")[1:] == ((-1, 0, 1), ((0, 2),))
    assert graph_of("A ((B 3)o) (A (B) A 2)o 2")[1:] == (
        (-1, 0, 1, 2, 0, 4, 4, 6, 7, 8, 8, 10), ((1, 3), (4, 7), (8, 11)),
    )  # fmt: skip
    for text in ("(A 2)o", "(A (B 3))o", "A)o"):
        with pytest.raises(ValueError, match=r"three beads or more|no bracket is open"):
            graph_of(text)
    chain = {"architecture": "A 20", "count": 60, "bonds": [[19, 0]]}
    same = Scene(RINGS | {"molecules": [chain, RINGS["molecules"][1]]})
    assert same.bonded.tolist() == Scene(RINGS).bonded.tolist()
    for pair, said in (([1, 0], "bonded already"), ([3, 20], "allowed: two of 0 to 19")):
        with pytest.raises(UserError, match=rf"molecules\.0\.bonds\.0: .*{said}"):
            Scene(RINGS | {"molecules": [chain | {"bonds": [pair]}]})


@given(WRITTEN)
def test_a_walk_through_a_molecule(text):
    """Comes to the beads in the order in which they are written, and is written as that."""
    beads, parents, _ = graph_of(text)
    bonds = np.array([pair for pair in enumerate(parents) if pair[1] >= 0], int).reshape(-1, 2)
    order, found, rings = spanned(len(beads), bonds)
    assert order.tolist() == list(range(len(beads))) and not len(rings)
    assert graph_of(written(beads, found)) == (beads, parents, ())


def test_sizes_of_ideal_rings():
    """(N^2 - 1) b^2 / (12 N) and twice as much, as the shipped scene says; the same on threads."""
    run = dpd.run(RINGS, progress=False)
    blocks = run.gyration_square.values.reshape(10, 5, 2).mean(axis=1)
    error = blocks.std(axis=0, ddof=1) / np.sqrt(10)
    exact = 399 / 240 * 3 / 4 * np.array([1, 2])
    assert (np.abs(blocks.mean(axis=0) - exact) < 4 * error).all() and (error < 0.1).all()
    assert np.isnan(run.end_to_end_square[:, 0]).all() and (run.end_to_end_square[:, 1] > 0).all()
    short = RINGS | {"steps": {"sample": 200}, "angle": {"stiffness": 2}}
    one, two = (dpd.run(short, progress=False, threads=n).kT for n in (1, 2))
    assert one.equals(two)


def test_a_gel_from_a_file(tmp_path):
    """A network through all faces, which is said, and a chain: box and molecules are the file's."""
    places = np.array([*product(range(4), repeat=3), (9, 0, 0), (10, 0, 0), (11, 0, 0)])
    ways, steps = np.eye(3, dtype=int), (16, 4, 1)
    bonds = [(k, (place + way) % 4 @ steps) for k, place in enumerate(places[:64]) for way in ways]
    order = np.random.default_rng(1).permutation(67)
    still = np.zeros((3, 67))
    write(Particles(
        (4.0,) * 3, (places[np.argsort(order)].T + 0.1) % 4, still.astype(np.int32), still,
        np.zeros(67, np.uint8), ("A",), order[[*bonds, (64, 65), (65, 66)]].astype(np.uint32),
    ), tmp_path / "gel.data")  # fmt: skip
    scene = {key: SCENE[key] for key in ("dimension", "repulsion", "integrator")} | {
        "bond": {"stiffness": 20, "length": 0.9}, "steps": {"sample": 40}, "observe": ["chains"],
        "start": {"method": "file", "path": str(tmp_path / "gel.data")}, "keep_state": True,
    }  # fmt: skip
    found = {len(kind.beads): kind for kind in Scene(scene).molecules}
    assert found.keys() == {3, 64} and len(found[64].rings) == 3 * 64 - 63
    make_start(Scene(scene), say=(said := []).append)
    assert any("bonded to their own images, as a gel is: 1;" in sentence for sentence in said)
    dpd.run(scene, output=tmp_path / "run.nc", progress=False)
    write(read(tmp_path / "run.nc"), tmp_path / "gel.gsd")
    one, two = (
        dpd.run(scene | {"start": {"method": "file", "path": str(tmp_path / name)}}, progress=False)
        for name in ("gel.gsd", "run.nc")
    )
    np.testing.assert_allclose(one.gyration_square, two.gyration_square, rtol=1e-6)
    law = {"target": 1, "axes": "xy-z", "tension": 6, "time": 0.5, "compressibility": 0.02}
    held = {"pressure": law, "bond": {"stiffness": 60, "length": 1.15}, "observe": ["thermo"]}
    sim, edges = dpd.Simulation(scene | held | {"steps": {"equilibrate": 2000}}, progress=False), []
    sim.run(20_000, until=lambda snapshot: edges.append(snapshot.box[2]), every=50)
    x, y, z = sim.result().pressure_tensor.mean("time").values.diagonal()
    assert z == pytest.approx(1, abs=0.2)
    assert np.mean(edges) * (z - (x + y) / 2) == pytest.approx(6, abs=0.6)


def test_a_membrane():
    """Upright lipids, heads 4.2 r_c apart through the face of the box, of which one lies down."""
    lipids = {"architecture": "H (T 2) T 2", "count": 8}
    scene = RINGS | {"box": [4, 5, 9], "molecules": [lipids, {"architecture": "W", "count": 3}]}
    scene["repulsion"] = {f"{i} {j}": 25 for i, j in ("HH", "HT", "HW", "TT", "TW", "WW")}
    up = np.array([[0, 0, 2.1], [0, 0, 1.1], [0, 0, 0.1], [0.1, 0, 1.1], [0.1, 0, 0.1]])
    sides = [up * [1, 1, side] + [0.4 * k, 1, 8.9] for k in range(4) for side in (1, -1)]
    sides[0] = sides[0][:, [2, 1, 0]] - sides[0][:1, [2, 1, 0]] + sides[0][:1]
    place = np.concatenate([*sides, np.full((3, 3), 4.0)]) % [4, 5, 9]
    found = look(scene, {"membrane": {"every": 20}}, place.T)
    first = {name: found[name][0] for name in ("area_per_molecule", "height", "thickness")}
    assert first == pytest.approx({"area_per_molecule": 5, "height": 9, "thickness": 3.36})
    assert found["tail_order"][0] == pytest.approx(1 - 1.5 * 2 / 16)


def test_bonds_of_two_types():
    run = dpd.run(PACKAGE / "scenes" / "typed_bonds.yaml", progress=False)
    assert run.end_to_end_square.mean() == pytest.approx(1, abs=0.03)  # standard error 0.7 %


def test_chains_of_several_lengths():
    """Whole molecules, near to the weights, of ideal sizes; pairs with a range of their own."""
    run = dpd.run(PACKAGE / "scenes" / "polydisperse.yaml", progress=False)
    sizes = run.end_to_end_square.values.mean(axis=0)
    off = sizes / (3 / 4 * np.array([7, 11, 19])) - 1  # of which errors are 1, 1.2 and 1.8 %
    assert (np.abs(off) < [0.04, 0.05, 0.075]).all()
    several = {"architecture": "A [8, 12, 20]", "weights": [1, 2, 1], "count": 101}
    kinds = Scene(RINGS | {"molecules": [several]}).molecules
    assert [(len(kind.beads), kind.count) for kind in kinds] == [(8, 25), (12, 51), (20, 25)]
    with pytest.raises(UserError, match=r"molecules\.0\.weights: .*: allowed: one positive number"):
        Scene(RINGS | {"molecules": [several | {"weights": [1]}]})
    halves = {"repulsion": {"A A": 10}, "soft": {"strength": 15, "range": 1}}
    short = {"repulsion": {"A A": 0}, "soft": {"strength": 25, "range": 0.7}}
    plain, same, less = (
        dpd.run(SCENE | change | {"steps": {"sample": 20}}, progress=False).pressure
        for change in ({}, halves, short)
    )
    np.testing.assert_allclose(plain, same, rtol=1e-9)
    assert (less < plain).all()


@pytest.mark.parametrize("suffix", ["data", "gsd"])
def test_laws_by_the_types_of_a_file(tmp_path, suffix):
    """Of molecules that differ in nothing else: the energy that types, numbers or names, say."""
    place = np.array([[1, 1.5, 1.9, 3, 3.6, 3.9], [1, 1.1, 1.7, 1, 1.2, 1.9], [1, 1, 1, 1, 1, 1.3]])
    types = {(0, 1): "soft", (1, 2): "stiff", (3, 4): "stiff", (4, 5): "soft"}
    types |= {(0, 1, 2): "1", (3, 4, 5): "2"}
    bonds, angles = (np.array([each for each in types if len(each) == n]) for n in (2, 3))
    names = np.zeros(6, int), ("A",)
    given = Particles((6.0,) * 3, place, 0 * place, 0 * place, *names, bonds, angles=angles)
    write(given._replace(types=types), path := tmp_path / f"typed.{suffix}")
    assert read(path).types == types
    scene = Scene({
        "dimension": 3, "repulsion": {"A A": 0}, "steps": {"sample": 1},
        "integrator": {"scheme": "gw-vv", "dt": 0.01},
        "bond": {"soft": {"stiffness": 4}, "stiff": {"stiffness": 50}},
        "angle": {1: {"stiffness": 3}, "2": {"stiffness": 7}},
        "start": {"method": "file", "path": str(path)},
    })  # fmt: skip
    stiffness, expected = {"soft": 4, "stiff": 50, "1": 3, "2": 7}, 0.0
    for beads, name in types.items():
        one, *other = np.diff(place[:, beads]).T
        size = np.sqrt(one @ one)
        for two in other:
            size = np.arccos(one @ two / size / np.sqrt(two @ two))  # from straight
        expected += stiffness[name] * size**2 / 2
    found = Simulation(system_of(scene), make_start(scene)).measure().energy
    assert found[0, OF_BONDS] == pytest.approx(expected)
    changed = merge(scene.data, {"bond": {"stiff": {"length": 1}}})
    assert Scene(changed).terms["bond"].law["stiff stiff"].stiffness == 50
    dpd.run(scene, output=tmp_path / "run.nc", progress=False)
    assert read(tmp_path / "run.nc").types == scene.types == types
    with pytest.raises(
        UserError, match=r"molecules\.0\.types\.soft: \[0, 5\]: no bond or angle, or typed"
    ):
        Scene(RINGS | {"bond": {"soft": {"stiffness": 1}}, "molecules": [
            {"architecture": "A 6", "count": 9, "types": {"soft": [[0, 5]]}}]})  # fmt: skip
