"""What git keeps of the long study, and how reports show it."""

import math
import os
import re
import shutil

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from PIL import Image

from dpd import files
from dpd.errors import UserError
from dpd.folders import ROOT
from dpd.pipeline.paper import Figure, Paper, read_config, read_paper
from dpd.pipeline.paths import LONG_STUDY, Results
from dpd.pipeline.sweep import Axis, Point, Sweep
from dpd.report import archive
from dpd.report.archive import keep_figures, manifest_of, restore
from dpd.report.page import shorter_points, write_page
from dpd.report.rows import read_rows
from dpd.scene.scene import Scene
from tests.test_report import VERDICTS, put_figure, verdict_table

PAPER, SWEEP = "one_1997", "lengths"
LIMIT = 12 * 2**20  # bytes of an archive: git keeps every version of it for ever
DT, BEADS, STEPS = 0.04, 1536, 1000
ROWS = {name: rest for name, (_, *rest) in VERDICTS.items()}


def scene(length, seed=1):
    """Of a few short chains."""
    return Scene({
        "dimension": 3, "box": 8, "molecules": [{"architecture": f"A {length}", "density": 3}],
        "repulsion": {"A A": 25}, "bond": {"stiffness": 4}, "seed": seed,
        "integrator": {"scheme": "gw-vv", "lambda": 0.5, "dt": DT},
        "steps": {"equilibrate": 10, "sample": STEPS}, "observe": ["thermo"],
    })  # fmt: skip


def paper(*sampling, replicas=1):
    """One sweep over two chain lengths, and one figure that it feeds."""
    axes = (
        Axis("length", (2, 4), "1", "chain length"),
        Axis("replica", tuple(range(replicas)), "1", "replica"),
    )
    points = tuple(
        Point(f"length={length},replica={replica}", (length, replica), scene(length, 1 + replica))
        for length in (2, 4)
        for replica in range(replicas)
    )
    sweeps = {SWEEP: Sweep(SWEEP, axes, points)}
    figures = {"fig02_shapes": Figure(sweeps=[SWEEP]), "drift": Figure()}
    return Paper(PAPER, "One", "J. One 1", sweeps, (), figures, sampling)


def put_run(results, point, seconds=1800.0):
    """The result of a run, with what the archive reads of it."""
    path = results / PAPER / "runs" / SWEEP / point.name / "run.nc"
    files.write(path, {}, {"seconds": seconds, "beads": BEADS, "steps": STEPS})
    return path


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """Folder of the archive, empty yet."""
    monkeypatch.setattr(archive, "ARCHIVE", tmp_path / "archive")
    monkeypatch.setattr(archive, "processor", lambda: "Some Processor")
    return tmp_path / "archive"


@pytest.fixture
def results(tmp_path):
    """Of a study with both runs and one of its two figures."""
    folder = tmp_path / "results"
    for point in paper().sweeps[SWEEP].points:
        put_run(folder, point)
    put_figure(folder / PAPER / "figures", PAPER, "fig02_shapes", ROWS)
    return folder


def keep(results, runs_from=math.inf, of=None):
    """Archive a study."""
    return keep_figures(LONG_STUDY, Results(str(results)), [of or paper()], runs_from)


def test_the_archive_of_a_study(kept, results):
    """Its figures in fewer colours, and what made them: nothing that tells whose machine."""
    written = keep(results)
    found = manifest_of(LONG_STUDY)
    ((part, made),) = found["parts"].items()
    assert made["machine"] == {"processor": "Some Processor", "cores": os.cpu_count()}
    assert re.fullmatch(r"\d{4}-\d\d-\d\d", made["date"]) and made["commit"]
    assert {"numpy", "numba", "Python"} <= set(made["versions"])
    figure = f"{PAPER}/fig02_shapes"
    assert found["figures"] == {figure: part}
    names = {str(path.relative_to(kept / LONG_STUDY)) for path in written}
    assert names == {"verdicts.csv", f"{figure}.png", f"{figure}.nc", "manifest.yaml", "runs.csv"}
    runs = archive.runs_of(LONG_STUDY)
    assert {*runs.index} == {f"{PAPER}/runs/{SWEEP}/length={n},replica=0.nc" for n in (2, 4)}
    assert (runs == [part, BEADS, STEPS, 1800]).all(axis=None)
    assert str(results) not in (kept / LONG_STUDY / "manifest.yaml").read_text()
    source, target = results / PAPER / "figures" / "fig02_shapes", kept / LONG_STUDY / figure
    assert source.with_suffix(".nc").read_bytes() == target.with_suffix(".nc").read_bytes()
    old, new = (Image.open(path.with_suffix(".png")) for path in (source, target))
    apart = np.abs(np.subtract(old.convert("RGB"), new.convert("RGB"), dtype=float))
    assert new.mode == "P" and apart.mean() < 1
    assert len(read_rows(kept / LONG_STUDY / "verdicts.csv")) == len(ROWS)


def test_an_archive_grows_on_several_machines(kept, results, tmp_path):
    """What was made elsewhere stays, with its verdicts, files and what made it, while asked for."""
    keep(results)
    figure, drift = f"{PAPER}/fig02_shapes", f"{PAPER}/drift"
    picture, manifest = kept / LONG_STUDY / f"{figure}.png", kept / LONG_STUDY / "manifest.yaml"
    old = picture.read_bytes()
    (part,) = manifest_of(LONG_STUDY)["parts"]
    manifest.write_text(manifest.read_text().replace(part, "2020-01-01 abc"))
    other, rows = tmp_path / "elsewhere", {"slow": ("check", "deviates", 1.0)}
    put_figure(other / PAPER / "figures", PAPER, "drift", rows)
    keep(other)
    found = manifest_of(LONG_STUDY)
    assert found["figures"] == {figure: "2020-01-01 abc", drift: part}
    assert list(found["parts"]) == ["2020-01-01 abc", part]
    assert picture.read_bytes() == old and (kept / LONG_STUDY / f"{drift}.nc").is_file()
    rows = read_rows(kept / LONG_STUDY / "verdicts.csv")
    assert [row["figure"] for row in rows] == ["fig02_shapes"] * len(ROWS) + ["drift"]
    with pytest.raises(UserError, match="no figure is there to keep"):
        keep(tmp_path / "nothing here")
    keep(other, of=Paper(PAPER, "", "", {}, (), {"drift": Figure()}))
    assert {path.stem for path in (kept / LONG_STUDY / PAPER).iterdir()} == {"drift"}
    assert {row["figure"] for row in read_rows(kept / LONG_STUDY / "verdicts.csv")} == {"drift"}


def test_long_runs_go_to_another_machine_and_back(kept, results, monkeypatch, tmp_path):
    """Those that took as long as asked for, byte for byte; a run that is there is left alone."""
    monkeypatch.setattr(archive, "read_study", lambda study: {})
    monkeypatch.setattr(archive, "read_config", lambda: {"papers": [PAPER]})
    monkeypatch.setattr(archive, "read_paper", lambda name, study: paper())
    monkeypatch.setattr(archive, "results_of", lambda study: Results(str(tmp_path / "new")))
    first = paper().sweeps[SWEEP].points[0]
    put_run(results, first, seconds=7300.0)
    keep(results)
    assert not list(kept.rglob("runs/*/*.nc"))
    assert restore(LONG_STUDY) == []
    keep(results, runs_from=2.0)
    (there,) = (kept / LONG_STUDY / PAPER / "runs").rglob("*.nc")
    assert there.name == f"{first.name}.nc"
    (written,) = restore(LONG_STUDY)
    assert written == tmp_path / "new" / PAPER / "runs" / SWEEP / first.name / "run.nc"
    assert written.read_bytes() == there.read_bytes()
    written.write_bytes(b"mine")
    assert restore(LONG_STUDY) == [] and written.read_bytes() == b"mine"


def test_only_the_long_study_is_kept_whole(kept, results, monkeypatch, tmp_path):
    """Of any other study verdicts, figure by figure; and how long all took, if made at once."""
    monkeypatch.setattr(archive, "read_config", lambda: {"papers": [PAPER]})
    monkeypatch.setattr(archive, "read_paper", lambda name, study: paper())
    drift, rows = tmp_path / "elsewhere", {"slow": ("check", "deviates", 1.0)}
    put_figure(drift / PAPER / "figures", PAPER, "drift", rows)
    folder = results
    monkeypatch.setattr(archive, "results_of", lambda study: Results(str(folder)))
    for study, number in (("quick", 2), (LONG_STUDY, 5)):
        for folder, there in ((results, len(ROWS)), (drift, len(ROWS) + 1)):
            written = archive.keep(study)
            assert len(read_rows(kept / study / "verdicts.csv")) == there
            assert len(written) == number - (folder == drift and study == LONG_STUDY)
    assert "minutes" not in manifest_of("quick")
    put_figure((folder := results) / PAPER / "figures", PAPER, "drift", rows)
    archive.keep("quick")
    assert manifest_of("quick")["minutes"] >= 0
    with pytest.raises(UserError, match="is none of the studies"):
        archive.keep("quik")


def test_what_git_has_of_the_long_study():
    """The figures that its manifest names, and the verdicts."""
    folder, figures = archive.ARCHIVE / LONG_STUDY, manifest_of(LONG_STUDY)["figures"]
    there = {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}
    kept = {f"{name}.{kind}" for name in figures for kind in ("png", "nc")}
    assert there == {*kept, archive.MANIFEST, archive.VERDICTS, archive.RUNS}
    assert sum((folder / name).stat().st_size for name in there) <= LIMIT


FIGURE = "nikunen_2007/fig05_exponents"


def test_archived_figures_are_drawn_and_judged_again(kept):
    """What is spoilt comes back; numbers that miss what a figure needs are refused."""
    git, one = ROOT / "results" / "archive" / LONG_STUDY, kept / LONG_STUDY
    with pytest.raises(UserError, match=r"manifest.yaml: no figures are archived there"):
        archive.redraw(LONG_STUDY)
    (one / FIGURE).parent.mkdir(parents=True)
    shutil.copy(git / f"{FIGURE}.nc", one / f"{FIGURE}.nc")
    Image.new("RGB", (1, 1)).save(one / f"{FIGURE}.png")
    (one / "verdicts.csv").write_text("spoilt")
    (one / "manifest.yaml").write_bytes(archive.manifest_text({"figures": {FIGURE: "here"}}))
    names = [f"{FIGURE}.png", "verdicts.csv"]
    assert archive.redraw(LONG_STUDY) == [one / name for name in names]
    again, table = (pd.read_csv(folder / "verdicts.csv") for folder in (one, git))
    expected = table[table.figure == FIGURE.split("/")[1]].reset_index(drop=True)
    pd.testing.assert_frame_equal(again, expected, rtol=1e-9, check_dtype=False)
    found, drawn = (
        np.asarray(Image.open(folder / f"{FIGURE}.png").convert("RGB"), int)
        for folder in (one, git)
    )
    assert found.shape == drawn.shape and (np.abs(found - drawn) < 50).mean() > 0.99
    assert archive.redraw(LONG_STUDY) == []
    with xr.open_dataset(one / f"{FIGURE}.nc") as data:
        older = data.load().drop_vars("tau")
    older.to_netcdf(one / f"{FIGURE}.nc")
    before = {path: path.read_bytes() for path in one.rglob("*") if path.is_file()}
    with pytest.raises(UserError, match=r"fig05_exponents.py: line \d+: .*tau"):
        archive.redraw(LONG_STUDY)
    assert {path: path.read_bytes() for path in one.rglob("*") if path.is_file()} == before


def test_a_report_with_an_archive(kept, results, tmp_path):
    """Value, error and verdict of the long runs in each row that they have, and what that means."""
    long_runs = verdict_table(PAPER, "fig02_shapes", {
        "alpha": ("simulated", "deviates", 0.3), "beta < 2": ("simulated", "replicated", 1.5),
    })  # fmt: skip
    long_runs.loc[1, "published"] = "< 3"  # since then the published number was read anew
    path = tmp_path / LONG_STUDY / "verdicts.csv"
    path.parent.mkdir()
    long_runs.to_csv(path, index=False)
    bare = Paper(PAPER, "One", "J. One 1", {}, (), {"fig02_shapes": Figure()})
    write_page("fast", "Short.", [bare], results, results / "report.html", path)
    text = (results / "report.html").read_text(encoding="utf-8")
    rows = {
        name: text.split(f'<tr id="{PAPER}-fig02_shapes-{number}"')[1].split("</tr>")[0]
        for number, name in enumerate(ROWS, 1)
    }
    cell = '<td class="c-long">'
    assert f"{cell}0.300 ± 0.010, deviates</td>" in rows["alpha"]
    assert '<span class="chip r">' in rows["alpha"] and "Values of longer runs" in text
    assert all(f"{cell}</td>" in rows[name] for name in rows if name != "alpha")


SAID = {"sweeps": [SWEEP], "where": "Sec. II"}


@pytest.mark.parametrize(
    "said, shorter",
    [
        ({"steps": STEPS}, []),
        ({"steps": STEPS + 10}, ["length 2", "length 4"]),
        ({"steps": STEPS + 10, "at": {"length": [4]}}, ["length 4"]),
        ({"steps": STEPS, "dt": 2 * DT}, ["length 2", "length 4"]),
        ({"duration": STEPS * DT + 1}, ["length 2", "length 4"]),
        ({"steps": STEPS, "runs": 2}, ["length 2", "length 4"]),
        ({"steps": STEPS, "beads": BEADS + 1}, ["length 2", "length 4"]),
        ({"steps": STEPS, "molecules": BEADS // 2}, ["length 4"]),
        ({}, []),
    ],
)
def test_points_with_less_sampling_than_the_paper(said, shorter):
    """Less time, at the paper's step if it has one of its own; or a smaller system."""
    assert [point["point"] for point in shorter_points(paper(SAID | said))] == shorter


def test_replicas_count_together():
    """Two runs have twice the time."""
    said = SAID | {"steps": 4 * STEPS, "at_least": True, "molecules": 1000}
    point = shorter_points(paper(said, replicas=2))[0]
    assert (point["time"], point["paper_time"], point["share"]) == ("80", "≥ 160", "0.5")
    assert point["system"] == "768 of 1000 molecules"


@pytest.mark.parametrize("name", read_config()["papers"])
def test_what_the_papers_say_fits_their_sweeps(name):
    """In every study each statement is about points that are there; the source is named."""
    for study in ("quick", LONG_STUDY):
        read = read_paper(name, study, only=[])
        assert read.sampling and all(said["where"] for said in read.sampling)
        named = [sweep for said in read.sampling for sweep in said["sweeps"]]
        whole = read_paper(name, study, only=named)
        shorter_points(whole)
        for said in read.sampling:
            for axis, labels in said.get("at", {}).items():
                for sweep in said["sweeps"]:
                    (found,) = [a for a in whole.sweeps[sweep].axes if a.name == axis]
                    assert set(labels) <= set(found.labels)
