"""Values of a sweep that another sweep measures first."""

import copy
import json

import numpy as np
import pytest
import xarray as xr

from dpd.analysis.structure import derive, peak
from dpd.errors import UserError
from dpd.pipeline.paper import PaperFile, read_paper
from dpd.scene.yaml import read_section
from paper_figures.liu_2008.shared import closest_contact
from tests.test_bad_input import with_value
from tests.test_pipeline import copy_repository, edit, planned, snakemake

PAPER, SWEEP, SOURCE = "liu_2008", "rigidity", "contacts"
TARGET = f"results/smoke/{PAPER}/sweeps/{SWEEP}.nc"
ASKED = (TARGET, "--config", "study=smoke")


@pytest.fixture(scope="module")
def sweep():
    """The sweep whose bonds rest at what monomers measure."""
    return read_paper(PAPER, "smoke", only=[SWEEP]).sweeps[SWEEP]


def contacts(first, samples=50):
    """A collected sweep of monomers whose g(r) begins at a place for each force."""
    scene = read_paper(PAPER, "smoke", only=[SOURCE]).sweeps[SOURCE].points[0].scene.data
    scene = copy.deepcopy(scene)
    scene["steps"]["sample"], scene["duration"] = samples * 40, {}
    r = np.arange(0.005, 1.0, 0.01)
    g = [[(r > edge + 0.01 * (block % 3 - 1)).astype(float) for block in range(50)]
         for edge in first.values()]  # fmt: skip
    along = ("force", "replica")
    return xr.Dataset(
        {
            "rdf": ((*along, "block", "r"), np.array(g)[:, None]),
            "kT": (along, np.ones((len(first), 1))),
            "beads": (along, np.full((len(first), 1), 800)),
            "scene": (along, [[json.dumps(scene)]] * len(first)),
        },
        {"force": list(first), "r": r},
    )


def test_closest_contact_is_the_median_over_configurations():
    """A third of the configurations begin a bin before, a third a bin after."""
    found = closest_contact(contacts({50: 0.2}).isel(force=0))
    assert found.value == pytest.approx(0.2, abs=5e-4)  # 16 of 50 lie below, 17 above
    assert found.undecided == "2 r_0 is of 20000 beads, these runs have 800"


def test_a_peak_beside_a_kink():
    """The fit keeps away from the kink; where the peak is at the kink, it is the highest bin."""
    r = np.arange(0.005, 2.0, 0.01)
    g = np.exp(-(((r - 0.62) / 0.2) ** 2)) * np.where(r < 0.5, 0.1, 1.0)
    assert peak(r, g, kink=0.5) == pytest.approx(0.62, abs=2e-3)
    assert abs(peak(r, g) - 0.62) > 0.01
    assert peak(r, np.where(r < 0.586, 0.0, np.exp(-r)), kink=0.586) == pytest.approx(0.595)


def test_values_go_into_the_scenes(sweep):
    """Each point takes that of its own force; digests follow the value."""
    found = derive(sweep, {SOURCE: contacts({50: 0.2, 100: 0.25})})
    lengths = {p.labels[0]: p.scene.data["bond"]["length"] for p in found.points}
    assert lengths == {50: 0.2, 100: 0.25}
    other = derive(sweep, {SOURCE: contacts({50: 0.2, 100: 0.26})})
    same = [a.scene.digest == b.scene.digest for a, b in zip(found.points, other.points)]
    assert all(sweep.planned_digest(point) != point.scene.digest for point in sweep.points)
    assert same == [p.labels[0] == 50 for p in sweep.points]


def test_blocks_of_several_configurations_are_refused(sweep):
    """With the key, the sweep, and what to do."""
    with pytest.raises(UserError, match=r"contacts: observe.rdf.every: 100 config.* at most"):
        derive(sweep, {SOURCE: contacts({50: 0.2, 100: 0.25}, samples=100)})


FORCE = {"set": "force", "values": [50, 100]}
GIVEN = {
    "bonds": {
        "scene": {"bond": {"length": 0.2}},
        "derive": {"bond.length": {"from": "cores", "quantity": "closest_contact"}},
        "axes": {"force": FORCE},
    },
    "cores": {"scene": {}, "axes": {"force": FORCE}},
}

WRONG = [
    (("bonds", "derive", "bond.length", "from"), "core", r"no sweep 'core'.*mean 'cores'"),
    (("bonds", "scene", "bond"), {"stiffness": 3}, r"the sweep's scene has no such key"),
    (("bonds", "axes", "force"), FORCE | {"values": [50, 200]}, r"has no force 200, which"),
    (("bonds", "axes"), {"stiffness": FORCE}, r"several values on the axis 'force'"),
    (("cores", "axes", "r_s"), {"set": "r", "values": [0, 1]}, r"values on the axis 'r_s'"),
    (("cores", "derive"), GIVEN["bonds"]["derive"], r"'cores' has derived values itself"),
]


def test_rules_that_do_not_fit():
    """One sentence that says which key and what is allowed."""
    read_section(PaperFile, {"title": "Mine", "sweeps": GIVEN}, "paper.yaml")
    for place, value, message in WRONG:
        with pytest.raises(UserError, match=message):
            given = {"title": "Mine", "sweeps": with_value(GIVEN, place, value)}
            read_section(PaperFile, given, "paper.yaml")


def runs(folder):
    """Rest length, and wall clock of the run, of every point."""
    found = {}
    for path in sorted((folder / f"results/smoke/{PAPER}/runs/{SWEEP}").glob("*/run.nc")):
        with xr.open_dataset(path) as run:
            length = json.loads(run.attrs["scene"])["bond"]["length"]
            found[path.parent.name] = (length, run.attrs["seconds"])
    return found


@pytest.mark.thorough
def test_a_changed_contact_runs_again_and_an_unchanged_one_does_not(tmp_path):
    """Through the pipeline: measure, derive, simulate; then other sources, then another core."""
    folder = copy_repository(tmp_path / "copy")

    def made():
        done = snakemake(folder, *ASKED)
        assert done.returncode == 0, (done.stdout + done.stderr)[-3000:]
        assert planned(folder, *ASKED) == {}
        return runs(folder)

    first = made()
    path = folder / "src" / "dpd" / "analysis" / "statistics.py"
    path.write_text(path.read_text() + "EDITED = 1\n")
    assert planned(folder, *ASKED)["simulate"] > 0
    assert made() == first  # the same runs, to the second that they took
    edit(
        folder / "config" / "papers" / f"{PAPER}.yaml",
        "  contacts:\n    scene:\n      <<: *monomers\n",
        "  contacts:\n    scene:\n      <<: *monomers\n      core: {radius: 0.25, force: 100}\n",
    )
    second = made()
    assert all(second[name][0] > first[name][0] for name in first)
