"""Trajectories in other programs, and in studies."""

import freud
import gsd.hoomd
import MDAnalysis
import numpy as np
import pytest
import yaml
from MDAnalysis.analysis.msd import EinsteinMSD

from dpd.files import read
from dpd.runs.run import simulate
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start
from tests.conftest import SCENE
from tests.test_pipeline import copy_repository, planned, snakemake
from tests.test_trajectory import CHAINS, unfolded


def test_freud_finds_the_same_structure(tmp_path):
    """The radial distribution function of each frame, against that of the run at the same steps."""
    scene = Scene(SCENE | {
        "box": 6, "steps": {"equilibrate": 100, "sample": 500},
        "observe": [
            {"rdf": {"every": 10, "range": 2.5, "bin": 0.05}}, {"trajectory": {"every": 10}}
        ],
    })  # fmt: skip
    simulate(scene, tmp_path / "run.nc", make_start(scene))
    found = freud.density.RDF(bins=50, r_max=2.5)
    with gsd.hoomd.open(tmp_path / "run.gsd") as file:
        for frame in file:
            found.compute(frame, reset=False)
    ours = read(tmp_path / "run.nc")[0]["rdf"].mean(axis=0)
    # freud counts neighbours per bead and density, N / V; we have (N - 1) / V, of 647 others.
    np.testing.assert_allclose(found.rdf * 648 / 647, ours, rtol=2e-3, atol=2e-3)
    assert ours.max() > 1.1


def test_mdanalysis_finds_the_same_bonds_and_displacements(tmp_path):
    scene = Scene(CHAINS | {
        "steps": {"equilibrate": 50, "sample": 400},
        "observe": [{"displacement": {"every": 4}}, {"trajectory": {"every": 4}}],
    })  # fmt: skip
    simulate(scene, tmp_path / "run.nc", make_start(scene))
    found = MDAnalysis.Universe(tmp_path / "run.gsd")
    assert len(found.trajectory) == 100 and len(found.atoms) == scene.beads
    np.testing.assert_array_equal(found.bonds.indices, scene.bonded)
    assert found.atoms.types.tolist() == [scene.species[kind] for kind in scene.kinds]
    np.testing.assert_allclose(found.dimensions, [7, 8, 2, 90, 90, 90])
    assert len(found.residues) == len(scene.lengths)
    np.testing.assert_array_equal(found.residues[3].atoms.indices, range(15, 20))
    # Its reader asks no file for times: it takes dt and the first time from its user.
    with gsd.hoomd.open(tmp_path / "run.gsd") as file:
        times = [float(frame.log["time"][0]) for frame in file]
    timed = MDAnalysis.Universe(tmp_path / "run.gsd", dt=times[1] - times[0], time_offset=times[0])
    np.testing.assert_allclose([step.time for step in timed.trajectory], times, rtol=1e-12)
    np.testing.assert_allclose(times, 0.02 * (50 + 4 * np.arange(1, 101)), rtol=1e-12)
    way = unfolded(tmp_path / "run.gsd")
    with gsd.hoomd.open(tmp_path / "run.gsd") as file:
        for number in (0, 50, 99):
            found.trajectory[number]
            np.testing.assert_allclose(
                found.atoms.positions, file[number].particles.position, atol=1e-6
            )
    way -= way.mean(axis=1, keepdims=True)  # less the drift of the box, as ours
    centres = way[:, :100].reshape(100, 20, 5, 3).mean(axis=2)
    msd = EinsteinMSD(
        MDAnalysis.Universe.empty(20, trajectory=True).load_new(centres), msd_type="xy", fft=False
    ).run()
    ours, _ = read(tmp_path / "run.nc")
    lags = np.rint(ours["lag_time"] / (4 * 0.02)).astype(int)
    expected = msd.results.msds_by_particle[lags[:10]]
    np.testing.assert_allclose(ours["msd_centre"][:10, :20], expected, rtol=2e-4, atol=1e-5)


def paper_of(**sweeps):
    return yaml.safe_dump({
        "title": "A paper of mine", "reference": "nowhere", "figures": {},
        "sweeps": {name: {"scene": scene, "replicas": 2} for name, scene in sweeps.items()},
    })  # fmt: skip


@pytest.fixture
def papers(tmp_path):
    """A copy of the repository with two papers; one sweep of the first has trajectories."""
    folder = copy_repository(tmp_path / "copy")
    seen = SCENE | {"observe": ["thermo", {"trajectory": {"every": 5}}]}
    for name, text in (
        ("mine", paper_of(fluid=seen, plain=SCENE)), ("other", paper_of(fluid=SCENE))
    ):  # fmt: skip
        (folder / "config" / "papers" / f"{name}.yaml").write_text(text)
    return folder


OF_PAPERS = ("--config", "study=smoke", "papers=[mine,other]")


@pytest.mark.thorough
def test_a_study_makes_trajectories(papers):
    """Of those runs alone: not of others of the same name, nor of others of the same paper."""
    done = snakemake(papers, *OF_PAPERS)
    assert done.returncode == 0, (done.stdout + done.stderr)[-3000:]
    results = papers / "results" / "smoke"
    made = [path.relative_to(results).parts for path in results.glob("*/runs/*/*/*.gsd")]
    assert sorted(made) == [
        ("mine", "runs", "fluid", f"replica={number}", "run.gsd") for number in (0, 1)
    ]
    assert planned(papers, *OF_PAPERS) == {}
