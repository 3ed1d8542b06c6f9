"""Sweeps that calculate: axes and studies as of others, points made once, and no simulation."""

import numpy as np
import pytest

from dpd.analysis.collect import calculate
from dpd.analysis.structure import derive
from dpd.commands.main import main
from dpd.errors import UserError
from dpd.pipeline.paper import read_paper
from dpd.pipeline.sweep import SweepFile, unfold
from dpd.scene.yaml import read_section
from paper_figures.crgw_2019.calculations import MonomerFluid
from tests.test_pipeline import copy_repository, planned

PAPER, SWEEP = "crgw_2019", "bead_virials"
GIVEN = {
    "theory": {"monomer_fluid": {"density": 3, "repulsion": 25}},
    "axes": {
        "density": {"set": "monomer_fluid.density", "values": [2, 3]},
        "repulsion": {"set": "monomer_fluid.repulsion", "values": [10, 25], "units": "kT / r_c"},
    },
}


def unfolded(given=GIVEN):
    """A sweep of theory."""
    return unfold(PAPER, "fluids", SweepFile(**given), "sweeps.fluids")


def test_points_and_values_are_those_of_the_axes():
    """Numbers over the axes, arrays over their own coordinate as well; the digest follows."""
    sweep = unfolded()
    assert [point.name for point in sweep.points] == [
        "density=2,repulsion=10", "density=2,repulsion=25",
        "density=3,repulsion=10", "density=3,repulsion=25",
    ]  # fmt: skip
    assert sweep.points[1].scene.plain() == {"density": 2, "repulsion": 25}
    longer = GIVEN | {"axes": {"density": {"set": "monomer_fluid.density", "values": [3]}}}
    assert unfolded(longer).calculated_digest != sweep.calculated_digest
    data = calculate(PAPER, sweep)
    assert data.pressure.dims == ("density", "repulsion")
    assert data.rdf.dims == ("density", "repulsion", "r")
    assert data.repulsion.attrs["units"] == "kT / r_c"
    at = MonomerFluid(density=3, repulsion=25).calculate()
    assert float(data.pressure.sel(density=3, repulsion=25)) == at["pressure"].value
    np.testing.assert_array_equal(data.rdf.sel(density=3, repulsion=25), at["rdf"].value)
    np.testing.assert_array_equal(data.r, at["r"].value)


def test_what_cannot_be_calculated_is_refused():
    """With file, key, and what is allowed; of a paper without calculations, what to write."""
    for theory, said in (
        ({"monomer": {}}, "need one calculation, not monomer; .*did you mean 'monomer_fluid'"),
        ({}, "need one calculation, not none; .*monomer_fluid"),
        ({"monomer_fluid": {"density": 3, "repulsion": 1, "a": 2}}, "unknown key 'a'; allowed: de"),
    ):
        with pytest.raises(UserError, match=said):
            unfolded({"theory": theory, "axes": {}})
    with pytest.raises(
        UserError, match=r"no file paper_figures/nikunen_2007/calculations\.py; write"
    ):
        unfold("nikunen_2007", "fluids", SweepFile(**GIVEN), "sweeps.fluids")


def test_a_calculation_that_fails_is_one_sentence(monkeypatch):
    """With the sweep, the point on its axes, the calculation, and how far it went."""
    density = {"set": "monomer_fluid.density", "values": [8]}
    theory = {"monomer_fluid": {"density": 8, "repulsion": 1e6}}
    said = "no solution at density 8 and repulsion 1e[+]06; the last state that converged has"
    with pytest.raises(UserError, match=rf"fluids \(density=8\).*monomer_fluid: .*{said}"):
        calculate(PAPER, unfolded({"theory": theory, "axes": {"density": density}}))
    monkeypatch.setattr(MonomerFluid, "calculate", lambda self: {"pressure": 1 / 0})
    with pytest.raises(UserError, match=r"sweeps.fluids .*: monomer_fluid: .*ZeroDivisionError"):
        calculate(PAPER, unfolded())


def test_keys_of_the_other_kind_are_refused():
    """Of a sweep that is calculated or simulated."""
    for given, said in (
        ({}, "need either 'scene' or 'theory'"),
        ({"theory": {}, "replicas": 2}, "paper.replicas: the sweep is calculated"),
    ):
        with pytest.raises(UserError, match=said):
            read_section(SweepFile, given, "paper.yaml", "paper")


@pytest.mark.parametrize("name", ["vh1_vh2", "vh1"])
def test_a_point_alone_is_that_of_the_whole_sweep(name):
    """A job reads no other point; a name that is none is refused as by the whole sweep."""
    whole = read_paper(PAPER, "quick", [name]).sweeps[name]
    for point in whole.points:
        (alone,) = read_paper(PAPER, "quick", [name], [point.name]).sweeps[name].points
        assert (alone.name, alone.labels) == (point.name, point.labels)
        assert alone.scene.digest == point.scene.digest and alone.scene.where == point.scene.where
    none = read_paper(PAPER, "quick", [name], ["none"]).sweeps[name]
    assert len(none.points) == len(whole.points)


def test_a_scene_takes_a_value_that_is_calculated():
    """Repulsion and rest length of the trimers, each of its own point."""
    paper = read_paper(PAPER, "smoke", only=["trimers", "trimer_repulsions"])
    sweep, source = paper.sweeps["trimers"], paper.theory["trimer_repulsions"]
    data = calculate(PAPER, source)
    for point in derive(sweep, {"trimer_repulsions": data}).points:
        at = data.sel(equation=point.labels[0], bond=point.labels[1])
        found = point.scene.data["repulsion"]["A A"]
        assert found == pytest.approx(float(at.repulsion), rel=1e-5)
        length = point.scene.data["bond"]["length"]
        assert length == pytest.approx(float(at.rest_length), rel=1e-5)


def test_commands_keep_both_kinds_apart(capsys):
    """Each says which stage is meant."""
    assert main(["simulate", "smoke", PAPER, SWEEP, "x", "-o", "x.nc"]) == 1
    assert "the command for it is: python -m dpd calculate" in capsys.readouterr().err
    assert main(["calculate", "smoke", PAPER, "oligomers", "-o", "x.nc"]) == 1
    assert "the command for it is: python -m dpd simulate" in capsys.readouterr().err


@pytest.mark.thorough
def test_a_figure_of_theory_starts_no_simulation(tmp_path):
    """A calculation and a figure, and nothing else."""
    target = f"results/smoke/{PAPER}/figures/fig01_bead_virial.csv"
    asked = (target, "--config", "study=smoke")
    assert planned(copy_repository(tmp_path), *asked) == {"calculate": 1, "draw_figure": 1}
