"""Bad papers and studies: one sentence with file, key, value and what is allowed."""

import pytest

from dpd.errors import UserError
from dpd.pipeline.study import read_paper
from tests.test_bad_input import FLUID, WRONG, key_of, places, refusal, with_value


@pytest.fixture(autouse=True)
def _own_cache(tmp_path, monkeypatch):
    """Nothing is found valid because it was before, and nothing is left in the user's cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


PAPER = {
    "title": "A title",
    "reference": "A journal",
    "sweeps": {
        "fluid": {
            "scene": FLUID,
            "replicas": 2,
            "axes": {
                "a": {"set": "repulsion.A A", "values": [15, 25], "units": "1", "long_name": "a"},
                "density": {"set": ["molecules.0.density"], "values": [3, 4]},
                "scheme": {"values": {"euler": {"integrator": {"scheme": "euler"}}}},
                "shifted": {"set": "seed", "values": [2, 3], "offset": 1},
                "length": {"set": "molecules.0.architecture", "values": [1], "text": "A {}"},
            },
            "seeds": "former",
            "series": ["kT"],
        },
        "contacts": {"scene": FLUID, "axes": {"a": {"set": "repulsion.A A", "values": [15, 25]}}},
        "later": {
            "scene": FLUID | {"thermostat": {"gamma": 4.5}},
            "axes": {"a": {"set": "repulsion.A A", "values": [25]}},
            "derive": {"thermostat.gamma": {"from": "contacts", "quantity": "closest_contact"}},
        },
    },
    "measurements": ["lammps"],
    "figures": {"fig": {"sweeps": ["fluid"], "measurements": ["lammps"]}},
}
STUDY = {
    "description": "A study",
    "papers": {
        "groot_warren_1997": {
            "fluid": {
                "scene": {"box": 5, "steps": {"sample": 5}, "duration": {"sample": 1}},
                "sampling": 2,
                "replicas": 1,
                "axes": {"a": [15, 30], "scheme": ["euler"]},
            }
        }
    },
}


@pytest.fixture
def unfold(monkeypatch):
    """Unfold a paper under a study, both given as data."""
    import dpd.pipeline.study as module

    def unfold(paper, study):
        texts = {"papers": paper, "studies": study}
        monkeypatch.setattr(module, "read_yaml", lambda path: texts[path.parent.name])
        return read_paper("groot_warren_1997", "smoke")

    return unfold


def axes_of(**axes):
    """The paper with other axes."""
    return with_value(PAPER, ("sweeps", "fluid", "axes"), axes)


DT = {"set": "integrator.dt", "values": [0.01, 0.02]}
PAPERS = [
    (with_value(PAPER, ("sweeps", "s t"), {"scene": FLUID}), ["sweeps", "'s t'", "small letters"]),
    (with_value(PAPER, ("sweeps", 5), {"scene": FLUID}), ["sweeps", "5", "not text"]),
    (with_value(PAPER, ("sweeps", "s" * 81), {"scene": FLUID}), ["sweeps", "up to 80"]),
    (axes_of(dt={"values": {"x" * 200: {}}}), ["sweeps.fluid.axes", "213 letters", "<= 200"]),
    (axes_of(dt=DT, **{"y" * 100: {"values": {"x" * 100: {}}}}), ["fluid.axes", "<= 200"]),
    (axes_of(replica=DT), ["axes.replica", "has this name already"]),
    (axes_of(seed=DT), ["axes.seed", "has this name already"]),
    (axes_of(dt=DT | {"values": [15, 15.0]}), ["axes.dt.values", "15 and 15.0", "named '15'"]),
    (axes_of(dt=DT | {"values": [15.0, 15.00001]}), ["15.0 and 15.00001", "first six digits"]),
    (axes_of(dt=DT | {"values": []}), ["axes.dt.values", "at least one"]),
    (axes_of(dt=DT | {"values": ["a/b"]}), ["axes.dt.values", "'a/b'", "letters, digits"]),
    (axes_of(dt=DT | {"values": [None]}), ["axes.dt.values", "None"]),
    (axes_of(dt=DT | {"values": [True]}), ["axes.dt.values", "True"]),
    (axes_of(dt=DT | {"values": ["x"], "offset": 1}), ["axes.dt", "'x' is text", "offset"]),
    (axes_of(dt=DT | {"set": "box.x"}), ["box.x", "cannot be set"]),
    (axes_of(dt=DT | {"set": "molecules.9.density"}), ["no item '9'", "count from 0"]),
    (axes_of(dt=DT | {"set": "a..b"}), ["axes.dt.set", "'a..b'"]),
    (axes_of(dt=DT | {"text": "{} {}"}), ["axes.dt.text"]),
    (axes_of(dt=DT, step=DT), ["axes.step", "integrator.dt", "the axis 'dt'"]),
    (axes_of(dt=DT, scheme={"values": {"a": {"integrator": {"dt": 0.04}}}}),
     ["axes.scheme", "integrator.dt", "the axis 'dt'"]),
    (axes_of(a=DT | {"values": list(range(1, 101))}, b={"values": {i: {} for i in range(100)}}),
     ["20000 points", "<= 5000"]),
    (with_value(PAPER, ("sweeps", "fluid", "replicas"), 1_000_000), ["replicas", "<= 1000"]),
    (with_value(PAPER, ("sweeps", "fluid", "scene"), FLUID | {"start": 5}), ["start", "5"]),
    (with_value(PAPER, ("sweeps", "fluid", "scene"), FLUID | {"steps": {"sample": "10"}}),
     ["steps.sample", "'10'"]),
    (with_value(axes_of(dt=DT), ("sweeps", "fluid", "scene", "seed"), "1"), ["seed", "'1'"]),
    (with_value(axes_of(dt={"set": "steps.equilibrate", "values": [1]}),
                ("sweeps", "fluid", "scene", "integrator"), {"scheme": "auto"}),
     ["integrator.scheme", "'auto'", "python -m dpd run"]),
]  # fmt: skip


def test_the_paper_and_the_study_are_good(unfold):
    """What the tables change is all that is wrong."""
    assert len(unfold(PAPER, STUDY).sweeps["fluid"].points) == 8
    assert len(unfold(PAPER, {"description": "none"}).sweeps["fluid"].points) == 16


@pytest.mark.parametrize(("paper", "named"), PAPERS, ids=lambda part: str(part)[-40:])
def test_papers_that_cannot_be_meant(unfold, paper, named):
    """File, key, value, and what is allowed, before a point is unfolded."""
    message = refusal(unfold, paper, {"description": "none"})
    assert message.startswith("config/papers/groot_warren_1997.yaml: ")
    for part in named:
        assert part in message, message


@pytest.mark.parametrize(
    ("change", "named"),
    [({"scene": {"steps": {"sample": "many"}}}, ["fluid (", "steps.sample: 'many'"]),
     ({"scene": {"box": None}}, ["fluid (", "box: None"]),
     ({"axes": {"a": ["x"]}}, ["fluid (a=x", "repulsion.A A: 'x'"]),
     ({"axes": {"q": [1]}}, ["axes: no axis 'q'; allowed: a, "]),
     ({"replicas": None}, ["fluid.replicas: None"])],
)  # fmt: skip
def test_a_mistake_of_a_study_is_not_blamed_on_the_paper_alone(unfold, change, named):
    """Its file is named, and key and value."""
    study = {"description": "none", "papers": {"groot_warren_1997": {"fluid": change}}}
    message = refusal(unfold, PAPER, study)
    for part in ("config/studies/smoke.yaml", *named):
        assert part in message, message


def test_where_there_is_no_axis_none_is_named(unfold):
    """Nor is a list of nothing."""
    study = {
        "description": "none",
        "papers": {"groot_warren_1997": {"fluid": {"axes": {"q": [1]}}}},
    }
    message = refusal(unfold, axes_of(), study)
    assert message.endswith("no axis 'q'; there are none")


@pytest.mark.few(40)
@pytest.mark.parametrize("place", list(places(PAPER)), ids=key_of)
def test_any_value_at_any_key_of_a_paper(unfold, place):
    """Either points with names of their own, or one sentence with the file."""
    any_value(lambda value: unfold(with_value(PAPER, place, value), {"description": "none"}))


@pytest.mark.parametrize("place", list(places(STUDY)), ids=key_of)
def test_any_value_at_any_key_of_a_study(unfold, place):
    """The same."""
    any_value(lambda value: unfold(PAPER, with_value(STUDY, place, value)))


def any_value(make):
    for value in WRONG:
        try:
            paper = make(value)
        except UserError as problem:
            message = str(problem)
            lines = message.splitlines()
            assert all(line.startswith("config/") and len(line) < 800 for line in lines), message
        else:
            for sweep in paper.sweeps.values():
                names = [point.name for point in sweep.points]
                assert len(set(names)) == len(names)
