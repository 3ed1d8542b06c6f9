"""The pipeline as a reader runs it, on a copy of the repository."""

import json
import os
import re
import shutil
import subprocess
import sys
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from numba.core.caching import UserProvidedCacheLocator

import dpd.jit  # noqa: F401  says where kernels are kept
from dpd.analysis.collect import first_scene
from dpd.analysis.published import published
from dpd.analysis.verdicts import COLUMNS
from dpd.digest import PACKAGE, ROOT
from dpd.pipeline.jobs import batches
from dpd.pipeline.paper import read_paper
from dpd.pipeline.study import read_config
from dpd.report.text import typeset
from dpd.stages import kernels_name
from dpd.start import start_digest, start_is_shared

PAPER = "groot_warren_1997"  # in which sweeps and plots are edited
PAPERS = read_config()["papers"]
KEPT_OUT = {".git", ".venv", ".snakemake", "results", "__pycache__", ".pytest_cache", ".ruff_cache"}


def copy_repository(to):
    """The sources without what they generate."""
    shutil.copytree(
        ROOT, to, ignore=lambda folder, names: KEPT_OUT & set(names), dirs_exist_ok=True
    )
    _share_kernels(to)
    return to


def _share_kernels(copy):
    """Let a copy use the kernels that these sources have compiled.

    Numba keeps them by the folder of their source, and knows them by what is in it.
    """
    kept, place = Path(os.environ["NUMBA_CACHE_DIR"]), UserProvidedCacheLocator
    for source in PACKAGE.rglob("*.py"):
        own = kept / place.get_suitable_cache_subpath(source)
        other = copy / "src" / "dpd" / source.relative_to(PACKAGE)
        theirs = kept / place.get_suitable_cache_subpath(other)
        if theirs != own and not theirs.exists():
            own.mkdir(parents=True, exist_ok=True)
            theirs.symlink_to(own)


def snakemake(folder, *arguments):
    """Run snakemake there."""
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    return subprocess.run(
        [sys.executable, "-m", "snakemake", "--cores", "2", *arguments],
        cwd=folder, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip


def planned(folder, *arguments):
    """Jobs that a dry run would do, by rule."""
    done = snakemake(folder, "-n", *arguments)
    assert done.returncode == 0, done.stdout + done.stderr
    text = done.stdout + done.stderr
    table = re.search(r"Job stats:\njob +count\n[- ]+\n(.*?)\ntotal", text, re.S)
    if table is None:
        assert "Nothing to be done" in text, text
        return {}
    jobs = dict(line.split() for line in table[1].splitlines())
    return {rule: int(count) for rule, count in jobs.items() if rule != "all"}


SMOKE = ("--config", "study=smoke")


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """A copy in which the smoke study has run."""
    folder = copy_repository(tmp_path_factory.mktemp("smoke"))
    done = snakemake(folder, *SMOKE)
    assert done.returncode == 0, (done.stdout + done.stderr)[-5000:]
    return folder


def edit(path, old, new):
    """Replace a piece of a file, which has to be there."""
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def jobs_of(papers, concerned=lambda scene: True):
    """How many jobs have runs of some scenes."""
    return sum(
        any(concerned(point.scene) for point in batch)
        for paper in papers
        for sweep in paper.sweeps.values()
        for batch in batches(sweep, 60)
    )


@pytest.mark.few(1)
@pytest.mark.parametrize("name", ["smoke", "quick", "paper"])
def test_dry_run_of_every_study(tmp_path, name):
    """Every study can be planned: a job per batch of runs, sweep, figure, and shared start."""
    folder = copy_repository(tmp_path / "copy")
    jobs = planned(folder, "--config", f"study={name}")
    papers = [read_paper(paper, name) for paper in PAPERS]
    scenes = [
        [point.scene for sweep in paper.sweeps.values() for point in sweep.points]
        for paper in papers
    ]
    starts = [{start_digest(scene) for scene in each if start_is_shared(scene)} for each in scenes]
    assert jobs["simulate"] == jobs_of(papers)
    assert jobs["make_start"] == sum(map(len, starts))
    assert jobs["collect"] == sum(len(paper.sweeps) for paper in papers)
    assert jobs["derive"] == sum(bool(s.derived) for p in papers for s in p.sweeps.values()) > 0
    assert jobs["draw_figure"] == sum(len(paper.figures) for paper in papers)
    assert not (folder / "results").exists()


@pytest.mark.thorough
def test_lint():
    """Snakemake's own lint has nothing to say but that no rule names a conda environment."""
    done = snakemake(ROOT, "--lint", *SMOKE)
    complaints = re.findall(r"^    \* (.+)$", done.stdout + done.stderr, re.M)
    assert {c for c in complaints if "conda environment" not in c} == set()


def test_sources_are_clean():
    """ruff finds nothing in sources, figures and tests."""
    for check in (["check"], ["format", "--check"]):
        done = subprocess.run(
            [sys.executable, "-m", "ruff", *check, "src", "paper_figures", "tests"],
            cwd=ROOT, capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stdout


def test_a_misspelt_study_is_refused(tmp_path):
    """The message names the studies; no traceback, no results."""
    folder = copy_repository(tmp_path / "copy")
    done = snakemake(folder, "--config", "study=smoek")
    assert done.returncode != 0
    assert "did you mean 'smoke'" in done.stdout + done.stderr
    assert "Traceback" not in done.stdout + done.stderr
    assert not (folder / "results").exists()


def assert_drawn(folder, figure):
    """Picture, PDF and plotted numbers with units."""
    assert (folder / f"{figure}.png").read_bytes().startswith(b"\x89PNG")
    assert (folder / f"{figure}.pdf").read_bytes().startswith(b"%PDF")
    numbers = xr.load_dataset(folder / f"{figure}.nc")
    assert numbers.attrs["figure"] == figure
    lacking = [
        n for n, v in numbers.data_vars.items() if v.dtype.kind == "f" and "units" not in v.attrs
    ]
    assert not lacking, f"{figure}: {lacking}"


def cheapest(paper):
    """The figure of the smoke study with the fewest runs, but some; a few take no time at all."""
    read = read_paper(paper, "smoke")
    costs = {
        name: sum(len(read.sweeps[sweep].points) for sweep in read.sweeps.keys() & figure.sweeps)
        for name, figure in read.figures.items()
    }
    return min(filter(costs.get, costs), key=costs.get)


def test_a_figure_of_each_paper(tmp_path):
    """From nothing to the picture; a second call does nothing."""
    folder = copy_repository(tmp_path / "copy")
    figures = {paper: cheapest(paper) for paper in PAPERS}
    places = {paper: Path("results/smoke") / paper / "figures" for paper in PAPERS}
    targets = [str(places[paper] / f"{name}.png") for paper, name in figures.items()]
    done = snakemake(folder, *targets, *SMOKE)
    assert done.returncode == 0, (done.stdout + done.stderr)[-5000:]
    for paper, name in figures.items():
        assert_drawn(folder / places[paper], name)
    assert planned(folder, *targets, *SMOKE) == {}


@pytest.mark.parametrize("paper", PAPERS)
def test_all_figures_are_made(study, paper):
    for figure in read_paper(paper, "smoke").figures:
        assert_drawn(study / "results" / "smoke" / paper / "figures", figure)


def test_every_published_number_has_a_verdict(study):
    """One row each, in the columns that are promised, with a reason where undecided."""
    table = pd.read_csv(study / "results" / "smoke" / "verdicts.csv")
    assert list(table.columns) == COLUMNS
    for paper in PAPERS:
        listed = sorted(entry["quantity"] for entry in published(paper).values())
        assert sorted(table.quantity[table.paper == paper]) == listed
    assert set(table.verdict) <= {"replicated", "deviates", "not reached at this scale"}
    undecided = table[table.verdict == "not reached at this scale"]
    assert undecided.note.notna().all()
    by_name = table[table.paper == PAPER].set_index("quantity")
    exact = by_name.loc["B2 / a at a = 25"]
    assert exact.verdict == "replicated" and exact.value == pytest.approx(0.03836, abs=1e-5)


def test_the_short_runs_have_the_right_pressure(study):
    """Within 1 % of Monte Carlo at dt 0.01 even here; the quick study asks for 0.3 %."""
    table = pd.read_csv(study / "results" / "smoke" / "verdicts.csv").set_index("quantity")
    row = table.loc["pressure at rho 3, a 25 (Monte Carlo reference)"]
    assert row.value == pytest.approx(23.653, rel=0.01)
    assert 0 < row.error < 0.1


def test_the_report_is_one_page(study):
    """Every figure inside, captions with system and seeds, verdicts, checks; nothing fetched."""
    page = (study / "results" / "smoke" / "report.html").read_text()
    figures = sum(len(read_paper(paper, "smoke").figures) for paper in PAPERS)
    assert page.count("data:image/png;base64,") == figures
    assert not re.search(r"""(src|href)=["']?(https?:)?//""", page)
    for word in (
        "noise seed of each run",
        "replica",
        "momentum per bead",
        "numba",
        "standard errors",
    ):
        assert word in page
    for entry in (entry for paper in PAPERS for entry in published(paper).values()):
        assert typeset(entry["quantity"]) in page


@pytest.mark.parametrize("paper", PAPERS)
def test_runs_conserve_momentum_and_fit_in_memory(study, paper):
    """What the report shows of each sweep: rounding, and less than 1 GiB a job.

    The Langevin controls are there because they do not conserve momentum; nor do walls and body
    forces.
    """
    for name in read_paper(paper, "smoke").sweeps:
        sweep = xr.load_dataset(study / "results" / "smoke" / paper / "sweeps" / f"{name}.nc")
        data = first_scene(sweep).data
        from_outside = {"walls", "body_force"} & set(data)
        conserved = float(sweep.momentum_per_bead.max()) < 1e-12
        is_langevin = data["thermostat"]["kind"] == "langevin"
        assert conserved == (not from_outside and not is_langevin), name
        assert float(sweep.peak_memory_MiB.max()) < 1024


def test_grown_melts_have_no_crossing(study):
    """What polymerization writes of itself: all asked for has grown, and nothing crossed."""
    starts = list((study / "results" / "smoke" / "liu_2008" / "starts").glob("*.nc"))
    grown = [start for start in map(xr.load_dataset, starts) if "conversion" in start]
    assert len(grown) > 3
    for start in grown:
        assert float(start.conversion[-1]) == 1
        assert int(start.relax_crossings.sum()) == 0 and start.relax_crossings.size > 0
        assert (np.diff(start.tried) >= 0).all()


def test_a_second_run_does_nothing(study):
    """All is made, nothing has changed."""
    assert planned(study, *SMOKE) == {}


@contextmanager
def edited(path, more):
    """A file with something added, for a while; Numba looks at its time as well."""
    kept, when = path.read_text(), path.stat().st_mtime_ns
    path.write_text(kept + more)
    try:
        yield
    finally:
        path.write_text(kept)
        os.utime(path, ns=(when, when))


SOURCES = (
    "src/dpd/engine/search.py",
    "src/dpd/observe/rdf.py",
    "src/dpd/analysis/statistics.py",
    "src/dpd/report/page.py",
    f"paper_figures/{PAPER}/fig06_interface.py",
)


def test_status_of_a_finished_study(study):
    """All runs and all other jobs are done, as Snakemake has it; nothing is left."""
    done = subprocess.run(
        [sys.executable, "-m", "dpd", "status", "results/smoke", "--json"],
        cwd=study, env=os.environ | {"PYTHONPATH": str(study / "src")}, capture_output=True,
        text=True, check=True,
    )  # fmt: skip
    found = json.loads(done.stdout)
    planned_runs = sum(
        len(sweep.points) for name in PAPERS for sweep in read_paper(name, "smoke").sweeps.values()
    )
    assert [run["state"] for run in found["runs"]] == ["done"] * planned_runs
    assert found["seconds_left"] is None and planned(study, *SMOKE) == {}


def test_edited_comments_rerun_nothing(study):
    """Nor do docstrings, anywhere from kernels to plots."""
    with ExitStack() as edits:
        for path in (study / name for name in SOURCES):
            edits.enter_context(edited(path, "# edited\n"))
            path.write_text(path.read_text().replace('"""', '"""Edited: ', 1))
        assert planned(study, *SMOKE) == {}


def test_an_edited_observable_reruns_the_scenes_that_name_it(study):
    """And what follows from their runs; no start, no kernel."""
    with edited(study / "src" / "dpd" / "observe" / "crossings.py", "EDITED = 1\n"):
        jobs = planned(study, *SMOKE)
    papers = [read_paper(name, "smoke") for name in PAPERS]
    naming = [
        any("crossings" in point.scene.observe for point in sweep.points)
        for paper in papers
        for sweep in paper.sweeps.values()
    ]
    assert jobs["simulate"] == jobs_of(papers, lambda scene: "crossings" in scene.observe) > 0
    assert jobs["collect"] == sum(naming)
    assert "compile_kernels" not in jobs and "make_start" not in jobs


def test_an_edited_term_reruns_the_scenes_that_have_it(study):
    """Their kernels are compiled before; their starts, which they share, stay."""
    with edited(study / "src" / "dpd" / "physics" / "pressure.py", "EDITED = 1\n"):
        jobs = planned(study, *SMOKE)
    papers = [read_paper(paper, "smoke") for paper in PAPERS]
    assert jobs["simulate"] == jobs_of(papers, lambda scene: "pressure" in scene.terms) > 0
    kernels = {
        (paper.name, kernels_name(point.scene))
        for paper in papers
        for sweep in paper.sweeps.values()
        for point in sweep.points
        if "pressure" in point.scene.terms
    }
    assert jobs["compile_kernels"] == len(kernels) and "make_start" not in jobs


def test_an_edited_plot_reruns_plots(study):
    """One figure, and the pages that hold it; so does what it shares with others."""
    folder = study / "paper_figures" / PAPER
    path = folder / "fig06_interface.py"
    (folder / "helper.py").write_text("ONE = 1\n")
    path.write_text(path.read_text() + f"from paper_figures.{PAPER}.helper import ONE  # noqa\n")
    once = {"draw_figure": 1, "join_verdicts": 1, "write_report": 1}
    assert planned(study, *SMOKE) == once
    done = snakemake(study, *SMOKE)
    assert done.returncode == 0, (done.stdout + done.stderr)[-3000:]
    assert planned(study, *SMOKE) == {}
    with edited(folder / "helper.py", "ONE = 2\n"):
        assert planned(study, *SMOKE) == once


def test_an_edited_sweep_runs_only_its_new_point(study):
    """A density added for the study: one run, and what follows from it."""
    runs = study / "results" / "smoke" / PAPER / "runs" / "equation_of_state_15"
    before = {path: path.stat().st_mtime_ns for path in runs.glob("*/run.nc")}
    edit(
        study / "config" / "papers" / f"{PAPER}.yaml",
        "smoke: [1, 2, 3, 5, 8]",
        "smoke: [1, 2, 3, 4, 5, 8]",
    )
    expected = {
        "simulate": 1, "collect": 1, "draw_figure": 2, "join_verdicts": 1, "write_report": 1
    }  # fmt: skip
    assert planned(study, *SMOKE) == expected
    done = snakemake(study, *SMOKE)
    assert done.returncode == 0, (done.stdout + done.stderr)[-3000:]
    assert re.search(r"^simulation \d+ s \(runs and starts: 1\)", done.stdout, re.M), done.stdout
    after = {path: path.stat().st_mtime_ns for path in runs.glob("*/run.nc")}
    assert {path: after[path] for path in before} == before
    assert len(after) == len(before) + 1
    newest = max(after, key=after.get)
    made = f"results/smoke/{PAPER}/sweeps/equation_of_state_15.nc"
    newest.unlink()
    (study / made).unlink()
    assert planned(study, made, *SMOKE) == {"simulate": 1, "collect": 1}
    assert snakemake(study, made, *SMOKE).returncode == 0 and newest.is_file()
    sweep = xr.load_dataset(study / made)
    assert 4 in sweep.density


def test_an_edited_kernel_reruns_simulations(study):
    """All runs; and a stage that is called by hand refuses what the old kernel made."""
    with edited(study / "src" / "dpd" / "physics" / "repulsion.py", "EDITED = 1\n"):
        jobs = planned(study, *SMOKE)
        papers = [read_paper(paper, "smoke") for paper in PAPERS]
        assert jobs["simulate"] == jobs_of(papers)
        done = subprocess.run(
            [
                sys.executable, "-m", "dpd", "collect", "smoke", PAPER, "fluid", "-o", "x.nc",
                "--runs", f"results/smoke/{PAPER}/runs/fluid",
            ],
            cwd=study, env=os.environ | {"PYTHONPATH": str(study / "src")},
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert done.returncode == 1
        assert "made by other sources" in done.stderr and "Traceback" not in done.stderr
        assert not (study / "x.nc").exists()
