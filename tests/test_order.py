"""Which run of a study begins first."""

import shutil

import pytest
import yaml

import dpd.pipeline.paper as module
from dpd.errors import UserError
from dpd.pipeline.jobs import priorities
from dpd.pipeline.paper import CONFIG, read_paper, read_study, studies


@pytest.fixture(scope="module")
def papers():
    """Two papers under the study quick."""
    return {name: read_paper(name, "quick") for name in ("liu_2008", "nikunen_2007")}


def in_order(papers, first=()):
    """Paper, sweep and work of all runs, the highest priority in front."""
    found = priorities(papers, first)
    runs = sorted(found, key=found.get, reverse=True)
    return [
        (paper, sweep, papers[paper].sweeps[sweep].point(point).scene.work)
        for paper, sweep, point in runs
    ]


def test_the_longest_run_is_first(papers):
    """All runs of a study, by their work in millions of bead-steps."""
    work = [round(amount / 1e6) for *_, amount in in_order(papers)]
    sweeps = [sweep for paper in papers.values() for sweep in paper.sweeps.values()]
    assert len(work) == sum(len(sweep.points) for sweep in sweeps)
    assert work == sorted(work, reverse=True)
    assert min(priorities(papers).values()) > 0


def test_sweeps_that_come_first(papers):
    """In their order, each from its shortest run; the others as without."""
    first = ["nikunen_2007.dynamics", "liu_2008.melts", "groot_warren_1997.chains"]
    runs = in_order(papers, first)
    shortest, sweeps = {}, []
    for paper, sweep, amount in runs:
        name = f"{paper}.{sweep}"
        if name not in first:
            break
        if name not in sweeps:
            sweeps.append(name)
        assert name == sweeps[-1]
        assert round(amount / 1e6) >= shortest.get(name, 0)
        shortest[name] = round(amount / 1e6)
    assert sweeps == first[:2]
    rest = runs[sum(f"{paper}.{sweep}" in first for paper, sweep, _ in runs) :]
    assert not any(f"{paper}.{sweep}" in first for paper, sweep, _ in rest)
    work = [round(amount / 1e6) for *_, amount in rest]
    assert work == sorted(work, reverse=True)


def test_studies_name_sweeps_that_there_are():
    """Those of the repository."""
    for study in studies():
        for name in read_study(study).first or ():
            paper, sweep = name.rsplit(".", 1)
            assert sweep in read_paper(paper, study, [sweep]).sweeps


@pytest.mark.parametrize(
    ("said", "words"),
    [
        (
            "liu_2008.melt",
            r"studies\.mine\.first\.0: liu_2008 has no sweep 'melt'.*did you mean 'melts'",
        ),
        ("liu_2009.melts", r"studies\.mine\.first\.0: 'liu_2009' is not in .*config/papers"),
        ("crgw_2019.hnc", r"studies\.mine\.first\.0: crgw_2019 has no sweep 'hnc'"),
        ("melts", r"studies\.mine\.first\.0: .*melts"),
    ],
)
def test_refused(tmp_path, monkeypatch, said, words):
    """A paper or a sweep that is none, with what is allowed."""
    shutil.copytree(CONFIG, tmp_path / "config")
    monkeypatch.setattr(module, "CONFIG", tmp_path / "config")
    config = yaml.safe_load((CONFIG / "config.yaml").read_text())
    config["studies"]["mine"] = {"description": "mine", "first": [said]}
    (tmp_path / "config" / "config.yaml").write_text(yaml.safe_dump(config))
    with pytest.raises(UserError, match=words):
        for paper in ("liu_2008", "crgw_2019"):
            read_paper(paper, "mine")
