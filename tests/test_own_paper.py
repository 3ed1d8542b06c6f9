"""A paper of one's own: the example that people copy, and the least that a paper needs."""

import shutil

import pandas as pd
import pytest

from tests.conftest import command
from tests.test_pipeline import copy_repository, edit, planned, snakemake


@pytest.fixture
def outside(tmp_path):
    """A clone, and a paper that stands elsewhere, with its name and options for snakemake."""
    folder, papers = copy_repository(tmp_path / "copy"), tmp_path / "my papers"
    there = {"PYTHONPATH": str(folder / "src"), "DPD_PAPERS_DIR": str(papers)}
    assert command("new", "--paper", "mine", cwd=folder, **there).returncode == 0
    edit(papers / "mine.yaml", "sample: 4000", "sample: 400")
    edit(papers / "mine.yaml", "values: [2, 3, 4, 5, 6]", "values: [3, 4]")
    figure = papers / "mine" / "scaled_pressure.py"
    (papers / "mine" / "shared.py").write_text("REPULSION = 25.0\n")
    edit(figure, "REPULSION = 25.0  # kT / r_c", "")
    edit(figure, "import numpy", "from paper_figures.mine.shared import REPULSION\nimport numpy")
    return folder, papers, ("--config", "papers=[mine]", f"papers_dir={papers}")


def test_a_paper_outside_of_the_clone_is_planned(outside):
    """Its runs and its figure; without the folder, or with a wrong one, a sentence says so."""
    folder, papers, asked = outside
    jobs = planned(folder, *asked)
    assert "simulate" in jobs and jobs["draw_figure"] == 1
    for options, said in (
        (asked[:2], "'mine' is not in config/papers; allowed: "),
        ((*asked[:2], "papers_dir=mine"), "'mine' is no whole path"),
        ((*asked[:2], "papers_dir=/nowhere"), "/nowhere: there is no such folder"),
    ):
        done = snakemake(folder, "-n", *options)
        assert done.returncode and said in done.stdout + done.stderr
    shutil.copy(papers / "mine.yaml", folder / "config" / "papers")
    done = snakemake(folder, "-n", *asked)
    assert done.returncode and "'mine' is there twice" in done.stdout + done.stderr


@pytest.mark.thorough
def test_a_paper_outside_of_the_clone_is_made(outside):
    """A value and a verdict, in a report of its own; the one of all papers stays, and so does its
    own where a new one fails. An edit of what its figure imports draws that again alone."""
    folder, papers, asked = outside
    results, shared = folder / "results" / "quick", ("report.html", "verdicts.csv")
    results.mkdir(parents=True)
    for name in shared:
        (results / name).write_text("of all papers")
    done = snakemake(folder, *asked)
    assert done.returncode == 0, (done.stdout + done.stderr)[-3000:]
    assert {(results / name).read_text() for name in shared} == {"of all papers"}
    page, template = results / "report-mine.html", folder / "src" / "dpd" / "report" / "page.html"
    assert "Pressure of the DPD fluid" in page.read_text() and "data:image/webp" in page.read_text()
    (row,) = pd.read_csv(results / "verdicts-mine.csv").itertuples()
    assert abs(row.value - 0.1) < 0.02 and row.published == 0.101
    assert planned(folder, *asked) == {}
    edit(papers / "mine" / "shared.py", "25.0", "24.0")
    drawn = {"draw_figure": 1, "join_verdicts": 1, "write_report": 1}
    assert planned(folder, *asked) == drawn
    edit(papers / "mine" / "shared.py", "24.0", "25.0")
    published = papers / "mine" / "published.yaml"
    published.write_text("# A comment.\n" + published.read_text())
    assert planned(folder, *asked) == {}
    edit(published, "value: 0.101", "value: 0.102")
    assert planned(folder, *asked) == drawn
    edit(published, "value: 0.102", "value: 0.101")
    before = page.read_bytes()
    edit(template, "simulated again</h1>", "simulated {{ nothing.at.all }} again</h1>")
    assert snakemake(folder, *asked).returncode != 0 and page.read_bytes() == before


def test_the_least_that_a_paper_needs(tmp_path):
    """A title and a sweep: it has a report, with what its runs say of themselves."""
    folder = copy_repository(tmp_path / "copy")
    scene = (folder / "src" / "dpd" / "scenes" / "fluid.yaml").read_text()
    scene = scene.replace("box: 10", "box: 6").replace("seed: 1\n", "").replace("2000", "200")
    indented = "".join(f"      {line}\n" for line in scene.splitlines())
    paper = f"title: A paper of mine\nsweeps:\n  fluid:\n    scene:\n{indented}"
    (folder / "config" / "papers" / "mine.yaml").write_text(paper)
    done = snakemake(folder, "--config", "papers=[mine]")
    assert done.returncode == 0, (done.stdout + done.stderr)[-3000:]
    page = (folder / "results" / "quick" / "report-mine.html").read_text()
    assert "A paper of mine" in page and "fluid" in page and "<p></p>" not in page
    table = (folder / "results" / "quick" / "verdicts-mine.csv").read_text()
    assert len(table.splitlines()) == 1  # its head
