"""Names that mean something in a shell: refused in one sentence, and never executed."""

import shutil
from contextlib import suppress
from pathlib import Path

import pytest
import yaml

import dpd.pipeline.paper as module
from dpd.errors import UserError
from dpd.folders import ROOT
from dpd.pipeline.paper import read_config, read_paper, read_study
from tests.test_bad_input import FLUID, with_value
from tests.test_bad_papers import PAPER

HOSTILE = "$(touch X)", "a b", "fluid\n", "-o", "../fluid", "", "x" * 5000 + "!"


@pytest.fixture
def config(tmp_path, monkeypatch):
    """A copy of config that tests may change, in a folder in which X would be made."""
    shutil.copytree(ROOT / "config", tmp_path / "config")
    (tmp_path / "paper_figures").symlink_to(ROOT / "paper_figures")  # with pages of papers
    monkeypatch.setattr(module, "CONFIG", tmp_path / "config")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    return tmp_path / "config"


def add_study(config, name, given):
    """One more in config.yaml."""
    data = yaml.safe_load((config / "config.yaml").read_text())
    data["studies"][name] = given
    (config / "config.yaml").write_text(yaml.safe_dump(data))


def assert_one_sentence(make, name):
    """Refused, with the name or its beginning, and what is allowed."""
    with pytest.raises(UserError) as caught:
        make()
    message = str(caught.value)
    assert "\n" not in message and len(message) < 800, message
    assert repr(name)[1:-1][:80].split(" ")[0] in message, message
    assert "letters" in message, message
    assert not Path("X").exists()


@pytest.mark.parametrize("name", HOSTILE)
def test_names_of_studies_and_papers(config, name):
    """Refused where they come from, even if there is such a file."""
    add_study(config, name, "smoke")
    papers = config / "papers"
    with suppress(OSError):  # the file system has no such names
        shutil.copy(papers / "groot_warren_1997.yaml", papers / f"{name}.yaml")
    assert_one_sentence(lambda: read_config({"study": name}), name)
    assert_one_sentence(lambda: read_config({"papers": [name]}), name)
    assert_one_sentence(lambda: read_study(name), name)
    assert_one_sentence(lambda: read_paper(name, "smoke"), name)


def test_a_study_with_another_seed(config):
    """Has a name of its own, so a place of its own, and all noise is another; the rest stays."""
    assert read_config({"seed": 1})["study"] == read_config()["study"] == "quick"
    assert read_config({"seed": 2})["study"] == "quick-seed2"
    one, other = (read_paper("crgw_2019", study) for study in ("smoke", "smoke-seed2"))
    seeds = set()
    for paper in (one, other):
        for sweep in paper.sweeps.values():
            seeds |= {(sweep.name, point.name, point.scene.data["seed"]) for point in sweep.points}
    assert len(seeds) == 2 * sum(len(sweep.points) for sweep in one.sweeps.values())
    for first, second in zip(one.theory.values(), other.theory.values()):
        for a, b in zip(first.points, second.points):
            given, sampled = a.scene.plain(), "seed" in type(a.scene).model_fields
            assert b.scene.plain() == (given | {"seed": 2} if sampled else given)
    for wrong in ("smoke-seed1", "smoke-seed02", "smoke-seed0"):
        with pytest.raises(UserError, match="is none of the studies"):
            read_study(wrong)
    add_study(config, "smoke-seed3", "smoke")
    with pytest.raises(UserError, match="another name"):
        read_study("smoke-seed3")


@pytest.mark.parametrize("name", HOSTILE)
def test_names_of_sweeps_figures_and_measurements(config, name):
    """And of axes and their labels; a measurement is one of a list."""
    fluid = PAPER["sweeps"]["fluid"]
    axis = fluid["axes"]["a"]
    choice = {"choice": {"values": {"plain": {}, name: {"repulsion": {"A A": 20}}}}}
    for paper in (
        with_value(PAPER, ("sweeps", "fluid"), {"scene": FLUID, "axes": choice}),
        PAPER | {"sweeps": {name: fluid}, "figures": {"fig": {"sweeps": [name]}}},
        PAPER | {"figures": {name: {"sweeps": ["fluid"]}}},
        with_value(PAPER, ("sweeps", "fluid", "axes"), {name: axis}),
    ):
        (config / "papers" / "mine.yaml").write_text(yaml.safe_dump(paper))
        if name == "-o" and "choice" in str(paper):  # a label stands behind its axis
            names = [point.name for point in read_paper("mine", "smoke").sweeps["fluid"].points]
            assert set(names) == {"choice=plain,replica=0", "choice=-o,replica=0"}
        else:
            assert_one_sentence(lambda: read_paper("mine", "smoke"), name)
    paper = PAPER | {"measurements": [name]}
    (config / "papers" / "mine.yaml").write_text(yaml.safe_dump(paper))
    with pytest.raises(UserError, match="lammps"):
        read_paper("mine", "smoke")
