"""The pipeline as a reader runs it, on a copy of the repository."""

import os
import re
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from pathlib import Path
from threading import Event

import pandas as pd
import pytest
import xarray as xr
from numba.core.caching import UserProvidedCacheLocator

import dpd.jit  # noqa: F401  says where kernels are kept
from dpd.analysis.verdicts import COLUMNS, published
from dpd.folders import PACKAGE, ROOT
from dpd.pipeline.jobs import batches
from dpd.pipeline.paper import read_config, read_paper
from dpd.report.text import typeset
from dpd.start import start_digest
from tests.conftest import command, python

PAPER = "groot_warren_1997"  # in which sweeps and plots are edited
PAPERS = read_config()["papers"]
GENERATED = shutil.ignore_patterns(".*", "results", "__pycache__")  # .git, .venv, caches of tools


def copy_repository(to):
    """The sources without what they generate."""
    shutil.copytree(ROOT, to, ignore=GENERATED, dirs_exist_ok=True)
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
GROWTH = []  # of the report while the smoke study runs: figures made, each time that it has more


def watch(page, over):
    """Note how many figures a report has, until the study is over."""
    while not over.wait(0.5):
        text = page.read_text(encoding="utf-8") if page.is_file() else ""
        if (said := re.search(r"(\d+) of \d+ figures are made", text)) and said[1] not in GROWTH:
            GROWTH.append(said[1])


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """A copy in which the smoke study has run."""
    folder, over = copy_repository(tmp_path_factory.mktemp("smoke")), Event()
    with ThreadPoolExecutor() as pool:
        pool.submit(watch, folder / "results" / "smoke" / "report.html", over)
        try:
            done = snakemake(folder, *SMOKE)
        finally:
            over.set()
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
    """Every study can be planned: a job per batch of runs, sweep, figure, and melt that grows."""
    folder = copy_repository(tmp_path / "copy")
    jobs = planned(folder, "--config", f"study={name}")
    papers = [read_paper(paper, name) for paper in PAPERS]
    grown = [
        {
            start_digest(p.scene)
            for sweep in paper.sweeps.values()
            for p in sweep.points
            if p.scene.start.work
        }
        for paper in papers
    ]
    assert jobs["simulate"] == jobs_of(papers)
    assert jobs["make_start"] == sum(map(len, grown)) > 0
    assert jobs["collect"] == sum(len(paper.sweeps) for paper in papers)
    assert jobs["draw_figure"] == sum(len(paper.figures) for paper in papers)
    assert not (folder / "results").exists()


def test_sources_are_clean():
    """ruff finds nothing in sources, figures and tests."""
    for check in (["check"], ["format", "--check"]):
        done = python("-m", "ruff", *check, "src", "paper_figures", "tests", cwd=ROOT)
        assert done.returncode == 0, done.stdout


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
        name: sum(
            len(read.sweeps[sweep].points) for sweep in read.sweeps.keys() & set(figure.sweeps)
        )
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


def test_all_figures_are_made(study):
    for paper in PAPERS:
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


def test_the_report_is_one_page(study):
    """Every figure inside, what made it, every published number; nothing fetched."""
    page = (study / "results" / "smoke" / "report.html").read_text()
    figures = sum(len(read_paper(paper, "smoke").figures) for paper in PAPERS)
    assert page.count("data:image/webp;base64,") == 2 * figures and len(page) < 4e6
    assert not re.search(r"""(src|<link[^>]* href)=["']?(https?:)?//|url\(["']?http""", page)
    for word in ("noise seed of each run", "replica", "numba"):
        assert word in page
    for entry in (entry for paper in PAPERS for entry in published(paper).values()):
        assert typeset(entry["quantity"].removeprefix("the same").lstrip(", ")) in page


def test_the_report_grows(study):
    """From its first figure on, while others are made, there is one."""
    made = list(map(int, GROWTH))
    assert made and 0 < made[0] < 10 and made == sorted(made)


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


def test_edited_comments_rerun_nothing(study):
    """Nor do docstrings, from kernels to plots; and so a second run that finds all made."""
    names = ("engine/neighbours", "observe/rdf", "analysis/statistics", "report/page")
    figure = f"paper_figures/{PAPER}/fig06_interface.py"
    with ExitStack() as edits:
        for path in (study / name for name in (*(f"src/dpd/{n}.py" for n in names), figure)):
            edits.enter_context(edited(path, "# edited\n"))
            path.write_text(path.read_text().replace('"""', '"""Edited: ', 1))
        assert planned(study, *SMOKE) == {}


def test_an_edited_plot_reruns_plots(study):
    """One figure, and the pages that hold it; so does what it shares with others."""
    folder = study / "paper_figures" / PAPER
    path = folder / "fig06_interface.py"
    (folder / "helper.py").write_text("ONE = 1\n")
    path.write_text(path.read_text() + f"from paper_figures.{PAPER}.helper import ONE  # noqa\n")
    once = {"draw_figure": 1, "join_verdicts": 1, "write_page": 1, "write_report": 1}
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
        "simulate": 1, "collect": 1, "draw_figure": 2, "join_verdicts": 1, "write_page": 1,
        "write_report": 1,
    }  # fmt: skip
    assert planned(study, *SMOKE) == expected
    done = snakemake(study, *SMOKE)
    assert done.returncode == 0, (done.stdout + done.stderr)[-3000:]
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
        done = command(
            "collect", "smoke", PAPER, "fluid", "-o", "x.nc",
            "--runs", f"results/smoke/{PAPER}/runs/fluid",
            cwd=study, PYTHONPATH=str(study / "src"),
        )  # fmt: skip
        assert done.returncode == 1
        assert "made by other sources" in done.stderr and "Traceback" not in done.stderr
        assert not (study / "x.nc").exists()
