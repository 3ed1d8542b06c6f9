"""Bad input: one sentence with file, key, value and what is allowed; no traceback, no hang."""

import copy
import math
import time

import pytest

from dpd.errors import UserError
from dpd.folders import PACKAGE, ROOT
from dpd.page import Observable, Term, names
from dpd.scene.molecules import MOST_BEADS
from dpd.scene.scene import Scene
from dpd.scene.sections import Basics
from dpd.scene.yaml import read_yaml
from tests.conftest import SCENE
from tests.test_extend import PAGES as OWN

FLUID = {key: SCENE[key] for key in SCENE if key != "observe"} | {"steps": {"sample": 10}}
pytestmark = pytest.mark.usefixtures("own_cache")


def refusal(make, *arguments):
    """The sentences of what must be refused, within seconds."""
    begun = time.process_time()
    with pytest.raises(UserError) as caught:
        make(*arguments)
    assert time.process_time() - begun < 3.0
    message = str(caught.value)
    assert all(len(line) < 1000 for line in message.splitlines()), message
    return message


# A text, and what the message has to name.
TEXTS = [
    (b"seed: 1\nbox: 4\nseed: 2", ["line 3", "seed", "twice", "line 1"]),
    (b"a: !!python/object:os.system x", ["not YAML", "python/object"]),
    (b"a: [1, 2", ["not YAML", "line 2"]),
    (b"\x00\x80", ["not YAML"]),
]


def test_texts_that_are_no_yaml(tmp_path):
    """Refused with file and, where it is known, line and key; or for what the system says."""
    path = tmp_path / "my.yaml"
    for text, named in TEXTS:
        path.write_bytes(text)
        message = refusal(read_yaml, path)
        assert message.startswith(f"{path}: ") and all(part in message for part in named), message
    assert "cannot be read" in refusal(read_yaml, tmp_path)
    assert "No such file" in refusal(read_yaml, tmp_path / "none.yaml")


def test_texts_that_are_plain(tmp_path):
    """Merge keys and aliases; numbers and words are what they look like, as in YAML 1.2."""
    path = tmp_path / "my.yaml"
    path.write_text(
        "a: &a {x: 1, y: 0.5}\nb: {<<: *a, y: 2}\nc: [no, On, 1:30, 2001-01-01, 1_000, '2']\n"
        "d: [true, null, ~, 0, -3, 010, 1e5, -2E-3, .5, 6.]\n"
    )
    data = read_yaml(path)
    assert data == {
        "a": {"x": 1, "y": 0.5}, "b": {"x": 1, "y": 2},
        "c": ["no", "On", "1:30", "2001-01-01", "1_000", "2"],
        "d": [True, None, None, 0, -3, 10, 1e5, -2e-3, 0.5, 6.0],
    }  # fmt: skip
    assert [type(each) for each in data["d"][3:7]] == [int, int, int, float]
    path.write_text("deep: {base: &b {<<: {x: 1}, x: 2}}\nother: {<<: *b, y: 3}\n")
    assert read_yaml(path)["other"] == {"x": 2, "y": 3}


MANY = [f"S{chr(97 + i // 26)}{chr(97 + i % 26)}" for i in range(300)]
# A change to FLUID, and what the message has to name: key, value, what is allowed or what to do.
SCENES = [
    ({"box": None}, ["box", "nothing after the colon"]),
    ({"steps": {"sample": 10**12}, "box": 40}, ["bead-steps", "two years"]),
    ({"observe": ["rdf"], "molecules": [{"architecture": "A", "count": 1}], "box": 6},
     ["observe: 'rdf'", "a single bead"]),
    ({"molecules": [{"architecture": "A 12", "density": 3}], "bond": {"stiffness": 50},
      "observe": [{"trace": {"every": 20}}], "steps": {"sample": 10**8}, "pages": [OWN["trace"]]},
     ["observe.trace.every", "1.8e+08 coordinates", "every >= 36"]),
    ({"observe": ["thermo", {"thermo": {"every": 2}}]}, ["observe", "'thermo'", "more than once"]),
    ({"observe": [{"thermo": {"every": 1}}], "steps": {"sample": 10**9}},
     ["observe.thermo.every", "10000000", "every >= 100"]),
    ({"start": {"forces": {"gamma": 9}}}, ["start.forces", "no effect", "relax"]),
    ({"start": {"forces": {"bond": {"length": 1}}, "relax": {"steps": 9, "dt": 0.01}}},
     ["start.forces", "'bond'", "core, gamma"]),
    ({"molecules": [{"architecture": "A 9999999 B 9999999", "count": 9999}]},
     ["molecules.0.architecture", "more beads than 1000000"]),
    ({"molecules": [{"architecture": s, "count": 1} for s in MANY],
      "repulsion": {f"{s} {t}": 25 for i, s in enumerate(MANY) for t in MANY[i:]}},
     ["molecules", "300 species", "<= 256"]),
    ({"boxx": 4}, ["boxx", "did you mean 'box'"]),
    ({"molecules": [{"architecture": "A"}]}, ["molecules.0", "density", "count"]),
    ({"molecules": [{"architecture": "A", "density": 0.001}]}, ["0.001", "'count: 1'"]),
    ({"integrator": {"scheme": "leapfrog", "dt": 0.1}}, ["integrator.scheme", "leapfrog", "euler"]),
    ({"box": 1.9}, ["box", "1.9", ">= 2"]),
    ({"observe": ["viscosity"]}, ["observe", "viscosity", "thermo"]),
    ({"observe": [{"thermo": {"every": 100}}]}, ["observe.thermo.every", "100", "1 to 10"]),
    ({"repulsion": {"A A": 25, "A C": 3}}, ["repulsion.A C", "'C'", "allowed: A"]),
    ({"repulsion": {"A A": float("nan")}}, ["repulsion.A A", "nan", "finite"]),
    ({"bond": {"stiffness": 2}}, ["bond", "single bead"]),
    ({"observe": [{"rdf": {"range": 3}}]}, ["observe.rdf.range", "3", "<= 2"]),
    ({"box": 2.2, "pairs": {"search": "list", "skin": 0.15}},
     ["pairs.skin", "2.3", "search: cells"]),
    ({"start": {"method": "polymerize"}}, ["start.method", "two dimensions"]),
    ({"integrator": {"scheme": "shardlow", "dt": 0.04}, "thermostat": {"kind": "langevin"}},
     ["'shardlow' lets pairs exchange momentum"]),
]  # fmt: skip

BLEND = {
    "molecules": [{"architecture": "A", "count": 99}, {"architecture": "B", "count": 99}],
    "repulsion": {"A A": 25, "A B": 30, "B B": 25},
}
LANGEVIN = BLEND | {"thermostat": {"kind": "langevin", "gamma": {"A": 4.5, "B": 9}}}
WALLS = {"axis": "z", "repulsion": 25}
ROUGH = WALLS | {"gamma": 9}
DRIVEN = {"axis": "x", "strength": 0.1}
SHEAR = {"shear": {"rate": 0.3}, "box": [4.5, 4, 4]}
RAMP = {"thermostat": {"kT": {"from": 1, "to": 2}}}
LIQUID = {"repulsion": {"A A": -40}, "many_body": {"repulsion": 25}}
CHI = {
    "molecules": [{"architecture": "A", "count": 96}, {"architecture": "B", "count": 96}],
    "repulsion": {"A A": 25, "B B": 25}, "chi": {"A B": 4},
}  # fmt: skip
# The same of pages: what each alone can refuse.
PAGES = [
    (BLEND | {"thermostat": {"gamma": {"A A": 4.5, "B B": 2}}},
     ["gamma: no value for 'A B'; add"]),
    (LANGEVIN | {"start": {"relax": {"steps": 10, "dt": 0.01}}}, ["add start.forces.gamma"]),
    ({"mass": {"C": 2}}, ["mass.C: no molecule has the species 'C'; allowed: A"]),
    ({"molecules": [{"architecture": "A3 B", "count": 1}]},
     ["repulsion.A A: no molecule has the species 'A'; allowed: A3, B; did you mean 'A 3'"]),
    ({"walls": WALLS, "dimension": 2}, ["walls.axis", "'z' is no axis", "x, y"]),
    ({"walls": ROUGH, "integrator": {"scheme": "shardlow", "dt": 0.04}},
     ["integrator.scheme", "'shardlow'", "'walls'", "gw-vv"]),
    ({"walls": WALLS, "observe": [{"rdf": {"range": 2}}]}, ["observe", "'rdf'", "'walls'"]),
    ({"walls": WALLS | {"velocity": [[1, 0, 0], [0, 0, 0]]}}, ["walls.velocity", "walls.gamma"]),
    ({"body_force": DRIVEN}, ["body_force", "brakes", "'opposite'"]),
    (SHEAR | {"shear": {"rate": -6.3}}, ["-6.3", "more than a cutoff", "-6.25 to 6.25"]),
    (SHEAR | {"box": [2.05, 4, 4]}, ["box", "2.05 along the flow", "4 along y", ">= 2.066"]),
    (SHEAR | {"integrator": {"scheme": "aboba", "dt": 0.04}}, ["scheme", "aboba", "dpd-vv"]),
    (SHEAR | {"walls": {"axis": "y", "repulsion": 25}}, ["remove one of them"]),
    ({"pressure": {"target": 9, "time": 0.4, "every": 11}},
     ["pressure.every: 11 steps are longer than the relaxation time; allowed: <= 10"]),
    ({"pressure": {"target": 24}, "observe": ["trace"], "pages": [OWN["trace"]]},
     ["observe: 'trace' cannot follow a molecule in a box that"]),
    ({"repulsion": {"A A": -40}},
     ["repulsion.A A: -40 draws beads onto each other; allowed: >= 0, or any number with"]),
    (LIQUID | {"pressure": {"target": 1}}, ["pressure.compressibility: the key is missing"]),
    (LIQUID | {"integrator": {"scheme": "auto"}}, ["schemes were measured without many-body"]),
    (BLEND | {"observe": [{"clusters": {"of": ["S"]}}]}, ["clusters.of: no molecule has the spe"]),
    (BLEND | {"observe": [{"clusters": {"of": ["A"], "within": 4}}]},
     ["clusters.within: 4 is more than half the box; allowed: <= 2"]),
    (SHEAR | {"observe": [{"clusters": {"of": ["A"]}}]}, ["'clusters' takes the images of"]),
    (BLEND | {"observe": ["clusters"]}, ["clusters.of: is missing; give species, as [A]"]),
    ({"thermostat": {"kT": {"to": 2}}}, ["thermostat.kT: the key 'from' is missing"]),
    (RAMP | {"schedule": [{"step": 9, "set": {"thermostat": 2}}]}, ["thermostat.kT: has a ramp"]),
    (RAMP | {"engine": {"name": "lammps"}}, ["thermostat.kT: is for our own engine"]),
    (CHI | {"chi": {"A B": 2}}, ["chi.A B: 2 is outside", "allowed: 3 "]),
    (CHI | {"repulsion": BLEND["repulsion"]}, ["chi.A B: the pair has a repulsion as well"]),
    (CHI | {"chi": {"A C": 4}}, ["chi.A C: no molecule has the species 'C'; allowed: A, B"]),
    (CHI | {"repulsion": {"A A": 25, "B B": 26}}, ["the same repulsion for A A and B B"]),
    (CHI | {"box": [4, 4, 4.5]}, ["chi.A B: no relation", "at density 2.667"]),
    (CHI | {"dimension": 2}, ["three dimensions"]),
    (CHI | {"thermostat": {"kT": 2}}, ["25 between like beads", "= 50"]),
]  # fmt: skip
ARCHITECTURES = [
    ("A (B (C)", ["A >>>(<<<B", "not closed"]),
    ("A ((B) C)", ["A (>>>(<<<B) C)", "no bead before this branch"]),
    ("((A 3)o)o", [">>>(<<<(A", "closed already"]),
    ("3 A", [">>>3<<< A", "nor a species"]),
    ("1A B 1A", [">>>1A<<< B 1A", "rings, '(A 20)o'"]),
    ("((((A 999) 999) 999) 999) 999", ["((>>>(<<<(A", f"more beads than {MOST_BEADS}"]),
    ("A " * 100 + "(B 0)", ["A (B >>>0<<<)", "nor a species"]),
]
PAGES += [
    ({"molecules": [{"architecture": text, "count": 1}]}, ["molecules.0.architecture: ", *named])
    for text, named in ARCHITECTURES
]


@pytest.mark.parametrize(("change", "named"), SCENES + PAGES, ids=lambda part: str(part)[:40])
def test_scenes_that_cannot_be_meant(change, named):
    """Named with key, value, and what is allowed."""
    message = refusal(Scene, FLUID | change, "my.yaml")
    assert message.startswith("my.yaml: ")
    for part in named:
        assert part in message, message


TABLE = str(ROOT / "tests" / "table.csv")
RELAX = {"steps": 10, "dt": 0.01}
# Beside the examples of the package: settings that none of those has.
CHAINS = FLUID | {
    "molecules": [{"architecture": "A 2 B C", "density": 3}],
    "repulsion": {"A A": 25, "A B": 30, "A C": 30, "B B": 25, "B C": 30, "C C": 25},
    "mass": {"A": 1, "C": 2},
    "fene": {"stiffness": {"A A": 30, "B A": 20, "B C": 10}, "length": 1.2},
    "pair": {"A B": TABLE}, "soft": {"strength": 3, "range": 0.7},
    "start": {
        "kT": 1, "seed": 3, "relax": RELAX, "forces": {"gamma": 4, "fene": {"length": 0.9}},
    },
    "schedule": [{"step": 10, "set": {"integrator.lambda": 0.6}}],
    "keep_state": True,
    "observe": [
        {key: {"every": 5}} for key in (
            "bond_lengths", "diffusion", "end_points", "trajectory",
        )
    ],
}  # fmt: skip
MORSE = {key: value for key, value in CHAINS.items() if key not in ("fene", "start", "pair")} | {
    "morse_bond": {"depth": 100, "alpha": {"A A": 4, "A B": 4, "B C": 3}, "length": 0.7},
    "observe": [{"configurational": {"every": 5}}],
}
EXAMPLES = {path.stem: read_yaml(path) for path in sorted((PACKAGE / "scenes").glob("*.yaml"))}
GROWN = EXAMPLES["melt_2d"] | {"start": {"method": "polymerize"}}
RANKED = FLUID | {"engine": {"name": "lammps", "ranks": 2}}


def whole(data):
    """A scene with all its defaults."""
    scene = Scene(data)
    observe = [{key: page.plain()} for key, page in scene.observe.items()]
    return {**scene.data, "observe": observe}


WRONG = [
    None, True, "", "x", "3", "2e1", " ", -1, 0, 2, 2.5, 3.0, 1e300, -1e300, 5e-324, math.nan,
    math.inf, -math.inf, 10**30, -(10**30), [], {}, [1], ["x", None], {"a": 1}, {1: {}}, [[]],
]  # fmt: skip


def places(data, inside=()):
    """Every key of nested dicts and lists, as a tuple."""
    items = data.items() if isinstance(data, dict) else enumerate(data)
    for part, value in items:
        yield (*inside, part)
        if isinstance(value, dict | list):
            yield from places(value, (*inside, part))


def with_value(data, place, value):
    """A copy of nested dicts and lists with one value put in."""
    changed = copy.deepcopy(data)
    at = changed
    for part in place[:-1]:
        at = at[part]
    at[place[-1]] = value
    return changed


def key_of(place):
    return ".".join(map(str, place))


# Each key that scenes have, in the last of those that have it.
KEYS = list({
    tuple(part for part in place if isinstance(part, str)): (data, place)
    for data in map(whole, (RANKED, *EXAMPLES.values(), GROWN, MORSE, CHAINS, FLUID))
    for place in places(data)
}.values())  # fmt: skip


def test_all_pages_are_tried():
    """A new one too."""
    tried = {part for _, place in KEYS for part in place}
    assert {*Basics.model_fields, *names(Term), *names(Observable)} <= tried


@pytest.mark.few(60)
@pytest.mark.parametrize(
    ("data", "place"), KEYS, ids=lambda x: key_of(x) if type(x) is tuple else ""
)
def test_any_value_at_any_key(data, place):
    """Either a scene, or one sentence with the file and the key or what it belongs to."""
    for value in WRONG:
        try:
            scene = Scene(with_value(data, place, value), "my.yaml")
        except UserError as problem:
            message = str(problem)
            lines = message.splitlines()
            assert all(line.startswith("my.yaml: ") and len(line) < 1000 for line in lines), message
            # What tables then have not, and looks that then come too late.
            more = {"architecture": "no molecule has the species", "sample": "longer than the run"}
            named = {*map(str, place), more.get(place[-1], place[0])}
            assert any(part in message for part in named), (place, value, message)
        else:
            assert 0 < scene.beads < 10**8 and math.isfinite(scene.work)
