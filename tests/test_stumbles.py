"""What a newcomer stumbles over: a sentence at the moment of the mistake, and nothing lost."""

import json
import shutil

import pytest
import xarray as xr
import yaml

from dpd.errors import UserError
from dpd.pipeline.paper import PaperFile
from dpd.report.text import sweep_line
from dpd.scene.scene import Scene
from dpd.scene.yaml import merge, read_section
from tests.conftest import SCENE, command
from tests.test_pipeline import copy_repository, planned, snakemake

CHAINS = merge(
    SCENE,
    {
        "box": 10,
        "molecules": {0: {"architecture": "A 9", "density": 3}},
        "bond": {"stiffness": 20},
        "observe": ["thermo"],
    },
)


def test_a_density_that_chains_miss_by_little_is_noted():
    """333 chains of 9 beads make 2.997 instead of 3, in captions too; a met one gets no note."""
    assert Scene(SCENE).notes == []
    scene = Scene(CHAINS)
    assert "333 molecules of 9 beads in a box of 10 x 10 x 10 make 2.997 inst" in scene.notes[0]
    values = {"kT": 1.0, "scene": json.dumps(scene.data), "beads": 1, "steps": 2, "seed": 3}
    sweep = xr.Dataset({key: ("replica", [value]) for key, value in values.items()})
    assert "(density 2.997 of whole molecules in place of 3)" in sweep_line(sweep)


def test_a_density_that_chains_miss_by_much_is_refused():
    """With density, box and count; the count that it proposes is allowed."""
    chains = merge(CHAINS, {"box": 4, "molecules": {0: {"architecture": "A 20"}}})
    with pytest.raises(
        UserError, match=r"molecules\.0\.density: 10 mol.* 4 x 4 x 4 .*of 3"
    ) as said:
        Scene(chains)
    assert "'count: 10'" in str(said.value)
    Scene(chains | {"molecules": [{"architecture": "A 20", "count": 10}]})


MINE = """title: A paper of mine
sweeps: {}
figures: {line: {sweeps: []}}
"""
FIGURE = """import xarray as xr
from matplotlib import pyplot as plt

TITLE = "A line."


def compute(data):
    return xr.Dataset({"y": ("x", [1.0, 2.0], {"units": "1"})})


def draw(numbers):
    figure, axes = plt.subplots()
    axes.plot(numbers.y)
    return figure


def measured(numbers):
    return {}
"""
ALONE = ("--config", "papers=[mine]")


@pytest.fixture
def mine(tmp_path):
    """A copy of the repository with a paper of one's own, which has one figure."""
    folder = copy_repository(tmp_path / "copy")
    (folder / "config" / "papers" / "mine.yaml").write_text(MINE)
    (folder / "paper_figures" / "mine").mkdir()
    return folder


BROKEN = {
    "measures nothing": (FIGURE.replace("return {}", "return"), "measured returned NoneType"),
    "not Python": (FIGURE.replace("(data):", "(data)"), "line 7: expected ':'"),
    "fails deep down": (
        FIGURE.replace("axes.plot(numbers.y)", "axes.plot(numbers.isel(x=7).y)"),
        "draw: paper_figures/mine/line.py: line 13: IndexError",
    ),
}


@pytest.mark.few(1)
@pytest.mark.parametrize("name", BROKEN)
def test_broken_figure_files(mine, name):
    """File, line and what is needed in one sentence, no traceback, nothing written."""
    text, words = BROKEN[name]
    (mine / "paper_figures" / "mine" / "line.py").write_text(text)
    source = {"PYTHONPATH": str(mine / "src")}
    done = command("figure", "quick", "mine", "line", "-o", "figures", cwd=mine, **source)
    assert done.returncode == 1
    assert done.stderr.startswith("error: ") and "paper_figures/mine/line.py: " in done.stderr
    assert words in done.stderr and len(done.stderr.strip().splitlines()) == 1
    assert not (mine / "figures").exists()


@pytest.mark.thorough
def test_a_renamed_sweep_keeps_its_runs(mine):
    """With `seeds: OLD_NAME` and its folder moved nothing is simulated again."""
    sweep = {"scene": SCENE | {"observe": ["thermo"]}}
    sweep["axes"] = {"a": {"set": "repulsion.A A", "values": [15, 25]}}
    path = mine / "config" / "papers" / "mine.yaml"

    def write_sweep(name, **more):
        sweeps = {"sweeps": {name: sweep | more}}
        path.write_text(yaml.safe_dump({"title": "Mine"} | sweeps))

    write_sweep("old")
    done = snakemake(mine, *ALONE)
    assert done.returncode == 0, done.stdout + done.stderr
    runs = mine / "results" / "quick" / "mine" / "runs"
    before = {path.parent.name: path.read_bytes() for path in runs.glob("old/*/run.nc")}
    assert len(before) == 2
    write_sweep("new", seeds="old")
    shutil.move(runs / "old", runs / "new")
    assert planned(mine, *ALONE) == {"collect": 1, "write_report": 1}
    assert snakemake(mine, *ALONE).returncode == 0
    after = {path.parent.name: path.read_bytes() for path in runs.glob("new/*/run.nc")}
    assert after == before
    write_sweep("new")  # with seeds of its own the runs are others: those there are refused
    assert snakemake(mine, *ALONE).returncode != 0


@pytest.mark.parametrize("seeds", [{"two": "one"}, {"one": "x", "two": "x"}])
def test_two_sweeps_never_share_their_noise(seeds):
    """What follows from both would look more certain than it is."""
    sweeps = {name: {"scene": {}, "seeds": seeds.get(name, name)} for name in ("one", "two")}
    with pytest.raises(UserError, match="the noise of the sweep 'one'"):
        read_section(PaperFile, {"title": "Mine", "sweeps": sweeps}, "mine.yaml")
    sweeps |= {"one": {"scene": {}, "seeds": "two"}, "two": {"scene": {}, "seeds": "one"}}
    read_section(PaperFile, {"title": "Two names changed", "sweeps": sweeps}, "mine.yaml")
