"""Bad papers and studies: one sentence with file, key, value and what is allowed."""

import pytest

from dpd.errors import UserError
from dpd.pipeline.paper import as_studied, read_paper
from tests.test_bad_input import FLUID, WRONG, key_of, places, refusal, with_value

pytestmark = pytest.mark.usefixtures("own_cache")
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
# The same, with what some studies have.
STUDIED = with_value(
    with_value(PAPER, ("sweeps", "fluid", "replicas"), {"paper": 2, "smoke": 1}),
    ("sweeps", "fluid", "axes", "a", "values"),
    {"paper": [15, 25], "smoke": [15, 30, 40]},
)
CONFIG = {
    "study": "smoke", "papers": ["groot_warren_1997"],
    "studies": {
        "paper": {"description": "All."}, "smoke": {"description": "Less."}, "night": "smoke",
    },
}  # fmt: skip


@pytest.fixture
def unfold(monkeypatch):
    """Unfold a paper, and config.yaml, given as data."""

    def unfold(paper, config=CONFIG, study="smoke"):
        def read(path):
            return {"papers": paper, "config": config}[path.parent.name]

        monkeypatch.setattr("dpd.pipeline.paper.read_yaml", read)
        return read_paper("groot_warren_1997", study)

    return unfold


def axes_of(**axes):
    """The paper with other axes."""
    return with_value(PAPER, ("sweeps", "fluid", "axes"), axes)


def sampling(**said):
    """The paper with a statement on how it has sampled."""
    return PAPER | {"sampling": [{"sweeps": ["fluid"], "where": "Sec. I"} | said]}


DT = {"set": "integrator.dt", "values": [0.01, 0.02]}
PAPERS = [
    (with_value(PAPER, ("sweeps", "s t"), {"scene": FLUID}), ["sweeps", "'s t'", "small letters"]),
    (axes_of(replica=DT), ["axes.replica", "has this name already"]),
    (axes_of(dt=DT | {"values": [15, 15.0]}), ["axes.dt.values", "15 and 15.0", "named '15'"]),
    (axes_of(dt=DT | {"values": [15.0, 15.00001]}), ["15.0 and 15.00001", "first six digits"]),
    (axes_of(dt=DT | {"values": ["a/b"]}), ["axes.dt.values", "'a/b'", "letters, digits"]),
    (axes_of(dt=DT | {"values": ["x"], "offset": 1}), ["axes.dt", "'x' is text", "offset"]),
    (axes_of(dt=DT | {"set": "box.x"}), ["box.x", "cannot be set"]),
    (axes_of(dt=DT | {"set": "molecules.9.density"}), ["no item '9'", "count from 0"]),
    (axes_of(dt=DT | {"set": "a..b"}), ["axes.dt.set", "'a..b'"]),
    (axes_of(dt=DT, step=DT), ["axes.dt", "another axis undoes its value at", "dt=0.01,step=0.02"]),
    (axes_of(dt=DT, scheme={"values": {"a": {"integrator": {"dt": 0.04}}}}),
     ["axes.dt", "another axis undoes its value"]),
    (axes_of(a=DT | {"values": list(range(1, 101))}, b={"values": {i: {} for i in range(100)}}),
     ["20000 points", "<= 5000"]),
    (with_value(axes_of(dt={"set": "steps.equilibrate", "values": [1]}),
                ("sweeps", "fluid", "scene", "integrator"), {"scheme": "auto"}),
     ["integrator.scheme", "'auto'", "python -m dpd run"]),
    (PAPER | {"measurements": ["scalling"]}, ["measurements.0: 'scalling'", "'scaling'"]),
    (PAPER | {"measurements": ["tension"]}, ["fig.measurements: no measurement 'lammps'"]),
    (axes_of(dt={"values": {"x" * 200: {}}}), ["sweeps.fluid.axes", "213 letters", "<= 200"]),
    (sampling(sweeps=["fluids"]), ["sampling.0.sweeps: no sweep 'fluids' with runs"]),
    (sampling(at={"lengths": [1]}), ["sweep fluid has no axis 'lengths'"]),
    (sampling(steps=1, duration=1.0), ["sampling"]),
]  # fmt: skip


def test_the_paper_and_the_studies_are_good(unfold):
    """What the tables change is all that is wrong."""
    assert len(unfold(PAPER).sweeps["fluid"].points) == 16
    for study, points in (("paper", 16), ("smoke", 12), ("night", 12)):
        assert len(unfold(STUDIED, study=study).sweeps["fluid"].points) == points


@pytest.mark.parametrize(("paper", "named"), PAPERS, ids=lambda part: str(part)[-40:])
def test_papers_that_cannot_be_meant(unfold, paper, named):
    """File, key, value, and what is allowed, before a point is unfolded."""
    message = refusal(unfold, paper)
    assert message.startswith("config/papers/groot_warren_1997.yaml: ")
    for part in named:
        assert part in message, message


@pytest.mark.parametrize(
    ("place", "value", "named"),
    [(("scene", "box"), {"paper": 8, "smoke": "wide"}, ["fluid (", "box: 'wide'"]),
     (("scene", "box"), {"paper": 8, "smok": 6}, ["box: 'smok' stands beside 'paper'", "'smoke'"]),
     (("axes", "a", "values"), {"paper": [1], "smoke": [2, 2]}, ["axes.a.values", "twice"]),
     (("axes", "a", "labels"), {"smoke": [15]}, ["axes.a.labels", "a list"]),
     (("axes", "scheme", "labels"), {"smoke": ["eule"]}, ["no label 'eule'", "'euler'"]),
     (("axes",), {"smoke": {}, "a": {}}, ["fluid.axes: 'a' stands beside 'smoke'"])],
)  # fmt: skip
def test_mistakes_in_what_a_study_has(unfold, place, value, named):
    """The paper's file is named, and key and value."""
    message = refusal(unfold, with_value(PAPER, ("sweeps", "fluid", *place), value))
    for part in ("config/papers/groot_warren_1997.yaml: sweeps.fluid", *named):
        assert part in message, message


def test_what_a_study_takes():
    """Its own, or its parent's; nothing where neither has any, or null; also inside of lists."""
    given = {
        "box": {"paper": 8, "smoke": 6}, "seed": {"smoke": 3},
        "pairs": {"paper": {"skin": 1}, "smoke": None},
        "observe": ["thermo", {"rdf": {"every": {"paper": 9, "night": 4}}}, {"smoke": "bonds"}],
        "empty": None,
    }  # fmt: skip
    known = ["paper", "smoke", "night"]
    one = as_studied(given, ["paper"], known, "")
    assert one == {
        "box": 8, "pairs": {"skin": 1}, "observe": ["thermo", {"rdf": {"every": 9}}], "empty": None,
    }  # fmt: skip
    other = as_studied(given, ["night", "smoke", "paper"], known, "")
    rdf = {"rdf": {"every": 4}}
    assert other == {"box": 6, "seed": 3, "observe": ["thermo", rdf, "bonds"], "empty": None}


@pytest.mark.parametrize(
    ("studies", "named"),
    [({"night": "quik"}, "studies.night: no study 'quik'"),
     ({"a": "b", "b": "a"}, "studies.a: no study 'b' above it"),
     ({"archive": "paper"}, "results/archive is not for a study")],
)  # fmt: skip
def test_bad_studies(unfold, studies, named):
    """A parent that there is not, or not yet; no description; a name that is taken."""
    config = CONFIG | {"studies": CONFIG["studies"] | studies}
    message = refusal(lambda: unfold(PAPER, config, next(iter(studies))))
    assert message.startswith("config/config.yaml: ") and named in message


@pytest.mark.few(40)
@pytest.mark.parametrize("place", [*places(STUDIED), *places(CONFIG)], ids=key_of)
def test_any_value_at_any_key(unfold, place):
    """Either points with names of their own, or one sentence with the file."""
    for value in WRONG:
        try:
            if place[0] in CONFIG:
                paper = unfold(PAPER, with_value(CONFIG, place, value))
            else:
                paper = unfold(with_value(STUDIED, place, value))
        except UserError as problem:
            message = str(problem)
            lines = message.splitlines()
            assert all(line.startswith("config/") and len(line) < 800 for line in lines), message
        else:
            for sweep in paper.sweeps.values():
                names = [point.name for point in sweep.points]
                assert len(set(names)) == len(names)
