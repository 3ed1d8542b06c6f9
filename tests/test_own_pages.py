"""Observables of a user's own: from a file outside of the package, like ours in every way."""

import importlib
import json
import linecache
import re
import sys

import jsonschema
import numpy as np
import pytest
import yaml

import dpd
from dpd.errors import UserError
from dpd.files import read
from dpd.folders import PACKAGE, ROOT
from dpd.runs.result import is_made
from dpd.scene.scene import Scene
from dpd.scene.yaml import read_yaml
from tests.conftest import SCENE as PLAIN
from tests.conftest import command, documented, folder_with, python

PAGE = '''"""The mean number of neighbours of a bead."""

from dpd.page import Change, Observable, setting


class Neighbours(Observable, key="neighbours"):
    """Mean number of other beads within a distance of a bead."""

    stands = frozenset(Change)
    gives = {"neighbours": (("sample",), "1", "neighbours of a bead")}
    within: float = setting("The distance.", 0.8, unit="r_c", gt=0, le=5)

    def measure(self, now):
        return 2 * len(now.pairs(self.within).i) / now.beads
'''
SCENE = PLAIN | {
    "molecules": [{"architecture": "A", "density": 2}, {"architecture": "B", "density": 1}],
    "repulsion": {"A A": 25, "A B": 30, "B B": 25},
    "steps": {"equilibrate": 4, "sample": 60},
    "observe": [{"neighbours": {"within": 0.9, "every": 20}}, {"configuration": {"every": 20}}],
}


folder = folder_with({"mine.py": PAGE, "scene.yaml": SCENE})


def neighbours_of(variables, box=4.0, within=0.9):
    """Of the last configuration, by brute force."""
    position = np.asarray(variables["position"])
    apart = position[:, :, None] - position[:, None]
    apart -= box * np.round(apart / box)
    return ((apart**2).sum(axis=0) < within**2).sum() / position.shape[1] - 1


def test_from_the_command_line(folder):
    """Measured as by hand; in the file with its unit; made longer to the same bits."""
    done = command("run", "scene.yaml", "-o", "run.nc", "--page", "mine.py")
    assert done.returncode == 0, done.stderr
    variables, _ = read("run.nc")
    assert variables["neighbours"].shape == (3,)
    assert variables["neighbours"][-1] == pytest.approx(neighbours_of(variables), rel=1e-12)
    found = dpd.load("run.nc").neighbours
    assert found.attrs["long_name"] == "neighbours of a bead"
    assert found.attrs["mean"] == pytest.approx(found.values.mean())
    np.testing.assert_allclose(dpd.load("run.nc").neighbours_time, [0.8, 1.6, 2.4])
    assert command("extend", "run.nc", "--sample", 40, "-o", "longer.nc").returncode == 0
    whole = SCENE | {"steps": {"equilibrate": 4, "sample": 100}, "pages": ["mine.py"]}
    longer = read("longer.nc")[0]["neighbours"]
    assert dpd.run(whole, progress=False).neighbours.values.tobytes() == longer.tobytes()


def test_an_edited_page_runs_again_and_a_comment_does_not(folder):
    """Also where the edit is in a file beside it; the plain fluid keeps its result."""

    def scene(**changes):
        return Scene(SCENE | {"pages": ["mine.py"]} | changes)

    dpd.run(scene(), output="run.nc", progress=False)
    plain = scene(observe=["configuration"], pages=[])
    dpd.run(plain, output="plain.nc", progress=False)
    assert is_made(scene(), "run.nc")
    (folder / "mine.py").write_text(
        PAGE.replace("return 2", "# pairs count twice\n        return 2")
    )
    assert is_made(scene(), "run.nc")
    (folder / "mine.py").write_text(PAGE.replace("return 2", "return 3"))
    assert not is_made(scene(), "run.nc") and is_made(plain, "plain.nc")
    with pytest.raises(UserError, match=r"run\.nc.*: is not the file that this was made with"):
        dpd.run(scene(), output="run.nc", progress=False)
    assert dpd.run(scene(), progress=False).neighbours[-1] > 1.4 * neighbours_of(read("run.nc")[0])
    with pytest.raises(UserError, match=r"mine\.py: is not the file that this was made with"):
        Scene(yaml.safe_load(read("run.nc")[1]["scene"]), "run.nc")


BAD = [
    (("2 * len", "2 * ln"), "line 14: NameError: name 'ln' is not defined"),
    (("return 2", "return [1, 2]  # 2"), "'neighbours' has the shape (2,) instead of ()"),
    (("return 2", "return float('nan')  # 2"), "'neighbours' has values that are not finite"),
    (('key="neighbours"', 'key="rdf"'), "'rdf' is a page of the package"),
    ((PAGE, "x = 1\n"), "there is no page in it"),
]


@pytest.mark.parametrize(("change", "said"), BAD, ids=range(len(BAD)))
def test_what_is_wrong_is_told_with_its_line(folder, change, said):
    """In one sentence with file and line, and no traceback."""
    (folder / "mine.py").write_text(PAGE.replace(*change))
    with pytest.raises(UserError) as caught:
        dpd.run(SCENE | {"pages": ["mine.py"]}, progress=False)
    message = str(caught.value)
    assert said in message and "\n" not in message, message


def test_settings_and_refusals_are_those_of_any_page(folder):
    """Bounds, unknown keys, names that are near, and changes that it has said nothing of."""
    with pytest.raises(UserError, match=r"neighbours\.within: 9 should be less than .* 5"):
        Scene(SCENE | {"pages": ["mine.py"], "observe": [{"neighbours": {"within": 9}}]})
    with pytest.raises(UserError, match="did you mean 'neighbours'"):
        Scene(SCENE | {"pages": ["mine.py"], "observe": ["neighbour"]})
    with pytest.raises(UserError, match="'neighbours' is not known"):
        Scene(SCENE)  # what another scene has loaded is not there
    (folder / "mine.py").write_text(PAGE.replace("    stands = frozenset(Change)\n", ""))
    with pytest.raises(UserError, match="takes the images of the box to stay"):
        Scene(SCENE | {"pages": ["mine.py"], "shear": {"rate": 0.1}})


def test_the_page_of_the_documentation(folder):
    """As it stands there, it measures what `chains` does."""
    text = (ROOT / "docs" / "guide" / "observables.md").read_text()
    (folder / "gyration.py").write_text(documented("`gyration.py`"))
    short = re.search("```python\n(import dpd\n+def span.*?)\nrun =", text, re.S)[1]
    (folder / "span.py").write_text(short)
    chains = {
        "molecules": [{"architecture": "A 5", "count": 30}],
        "bond": {"stiffness": 50, "length": 0.7},
        "repulsion": {"A A": 25},
        "observe": [{name: {"every": 5}} for name in ("gyration", "chains", "span", "end_to_end")],
        "pages": ["gyration.py", "span.py"],
    }
    run = dpd.run(SCENE | chains, progress=False)
    found = run.gyration_square.squeeze().values
    np.testing.assert_allclose(run.gyration, found, rtol=1e-9)
    assert float(run.span.mean()) == pytest.approx(float(run.end_square.mean()), rel=1e-9)


WATCHED = """
from dpd.page import Observable, setting


class Watched(Observable, key="watched"):
    gives = {
        "place": (("sample", "molecule", "axis"), "r_c", ""),
        "speed": (("sample", "molecule", "axis"), "r_c / tau", ""),
        "fastest": (("largest",), "r_c / tau", ""), "mean_place": (("run", "axis"), "r_c", ""),
        "place_at_last": (("last", "axis"), "r_c", ""),
        "place_of_two": (("frame", "axis"), "r_c", ""),
    }
    average: int = setting("Samples in a frame.", 2)

    def measure(self, now):
        place, speed = (x.reshape(30, 5, 3).mean(axis=1) for x in (now.unwrapped, now.velocities))
        mean = place.mean(axis=0)
        return {"place": place, "speed": speed, "fastest": abs(speed).max(), "mean_place": mean,
                "place_at_last": mean, "place_of_two": mean}
"""


def test_what_is_kept_and_compared(folder):
    """The second page of the documentation, by brute force, also where its run was made longer."""
    text = (ROOT / "docs" / "guide" / "observables.md").read_text()
    pages = re.findall("```python\n(.*?)```", text, re.S)
    (code,) = (page for page in pages if "class Wandering" in page)
    (folder / "wandering.py").write_text(code)
    (folder / "watched.py").write_text(WATCHED)
    scene = SCENE | {
        "molecules": [{"architecture": "A 5", "count": 30}],
        "bond": {"stiffness": 50, "length": 0.7},
        "repulsion": {"A A": 25},
        "observe": [{"wandering": {"every": 2}}, {"watched": {"every": 2}}],
        "pages": ["wandering.py", "watched.py"],
    }
    run = dpd.run(scene | {"steps": {"sample": 78}}, output="run.nc", progress=False)
    place, speed = run.place.values, run.speed.values
    assert place.shape == (39, 30, 3)
    np.testing.assert_allclose(run.wandered, ((place - place[0]) ** 2).mean(axis=1), atol=1e-12)
    for lag, memory in enumerate(run.memory[:16].values, start=1):
        expected = (speed[lag:] * speed[:-lag]).sum(axis=2).mean(axis=0)
        np.testing.assert_allclose(memory, expected, atol=1e-12)
    np.testing.assert_allclose(run.wandering_lag_time[:16], 0.08 * np.arange(1, 17))
    np.testing.assert_allclose(run.fastest, abs(speed).max(axis=(1, 2)))  # a block is a sample
    mean = place.mean(axis=1)
    np.testing.assert_allclose(run.mean_place, mean.mean(axis=0))
    np.testing.assert_allclose(run.place_at_last, mean[-1])
    np.testing.assert_allclose(run.place_of_two[:19], mean[:38].reshape(19, 2, 3).mean(axis=1))
    np.testing.assert_allclose(run.place_of_two[19], mean[38])
    dpd.run(scene | {"steps": {"sample": 30}}, output="part.nc", progress=False)
    assert command("extend", "part.nc", "--sample", 48).returncode == 0
    whole, longer = read("run.nc")[0], read("part.nc")[0]
    for name in whole:
        np.testing.assert_array_equal(whole[name], longer[name], err_msg=name)


FUNCTIONS = '''
"""Two functions; others are no observables."""
import numpy as np

LENGTH = 2


def size(snapshot):
    """Mean square of the positions along each axis."""
    return powers(snapshot.positions).mean(axis=0)


def height(snapshot):
    return snapshot.positions[:, 2].mean()


def powers(x):
    return np.abs(x) ** LENGTH
'''


def test_functions_and_objects_are_observables(folder, monkeypatch):
    """Of the same file by name and as an object, in runs that go on, and in a sweep."""
    (folder / "short.py").write_text(FUNCTIONS)
    named = SCENE | {
        "pages": ["short.py"],
        "observe": [{"size": {"every": 20}}, {"height": {"every": 20}}],
    }
    (folder / "scene.yaml").write_text(yaml.safe_dump({**named, "pages": []}))
    assert command("run", "scene.yaml", "-o", "run.nc", "--page", "short.py").returncode == 0
    run = dpd.load("run.nc")
    last = (read("run.nc")[0]["last_position"] ** 2).mean(axis=1)
    assert run["size"].dims == ("size_time", "size_index") and run.height.shape == (3,)
    np.testing.assert_allclose(run["size"][-1], last, rtol=1e-12)
    assert run["size"].long_name == "Mean square of the positions along each axis"
    assert run.height.attrs["mean"] == pytest.approx(run.height.values.mean())
    assert command("extend", "run.nc", "--sample", 40).returncode == 0
    monkeypatch.syspath_prepend(folder)
    short, mine = map(importlib.import_module, ("short", "mine"))
    plain = SCENE | {"observe": ["thermo"]}
    asked = [short.height, mine.Neighbours(within=0.9, every=20), "configuration"]
    given = dpd.run(plain, observe=asked, progress=False)
    np.testing.assert_array_equal(given.height, run.height[-1:])
    assert given.neighbours[-1] == pytest.approx(neighbours_of(given), rel=1e-12)
    swept = dpd.sweep(plain, {"box": [4]}, observe=[short.height], progress=False)
    assert swept.height.dims == ("box", "replica", "height_sample")
    with pytest.raises(UserError, match="is no observable; allowed: names, functions of a"):
        dpd.run(plain, observe=[short.powers], progress=False)
    (folder / "short.py").write_text(FUNCTIONS.replace("[:, 2]", "[:, 3]"))
    with pytest.raises(UserError, match=r"observe\.height: .*short\.py: line 14: IndexError: "):
        dpd.run(named, progress=False)  # before anything has run
    sys.modules.pop("short"), sys.modules.pop("mine")


def cell(text, number, **names):
    """What a cell of a notebook defines, as IPython keeps it."""
    place = f"<ipython-input-{number}-0>"
    linecache.cache[place] = (len(text), None, text.splitlines(keepends=True), place)
    names |= {"__name__": "__main__"}
    exec(compile(text, place, "exec"), names)
    return names


def test_a_cell_of_a_notebook(folder, monkeypatch):
    """Its functions and classes go on in fresh processes; what else it does is done once."""
    monkeypatch.delattr(sys.modules["__main__"], "__file__", raising=False)
    text = FUNCTIONS + "done.append(dpd.run(scene, observe=[height], output='run.nc'))\n"
    done = []
    cell(text, 1, done=done, dpd=dpd, scene=SCENE | {"observe": []})
    assert len(done) == 1 and done[0].height.shape == (1,)
    assert command("extend", "run.nc", "--sample", 20).returncode == 0
    scene = Scene(SCENE, pages=[cell(PAGE, 2)["Neighbours"]])
    assert Scene.of_result(json.dumps(scene.data), "run.nc").observe["neighbours"].within == 0.9
    with pytest.raises(UserError, match="'Neighbours' stands in no file"):
        exec(PAGE, names := {"__name__": "__main__"})
        Scene(SCENE, pages=[names["Neighbours"]])


def test_a_script_that_would_run_itself(folder):
    """Wherever its function is needed; and one that does so only when it is called."""
    run = "dpd.run('scene.yaml', observe=[mine], progress=False)"
    script = "import dpd\ndef mine(snapshot):\n    return snapshot.time\n"
    for text, code in ((run, 1), (f"if __name__ == '__main__':\n    {run}", 0)):
        (folder / "script.py").write_text(f"{script}{text}\n")
        (folder / "scene.yaml").write_text(yaml.safe_dump(SCENE | {"observe": ["configuration"]}))
        done = python("script.py")
        assert done.returncode == code, done.stderr
        assert ("script.py: line 4: this file is imported wherever" in done.stderr) == code


def test_helpers_of_two_folders_with_one_name(folder):
    """Each page has that of its own folder; an edited one is the new one, in the same process."""
    for name, number in (("one", 1), ("two", 2)):
        (folder / name).mkdir()
        (folder / name / "helper.py").write_text(f"V = {number}\n")
        page = PAGE.replace("neighbours", name).replace(
            "from dpd", "from helper import V\nfrom dpd", 1
        )
        (folder / name / f"{name}.py").write_text(page.replace("return 2", "return V + 0 * 2"))
    both = {
        "pages": ["one/one.py", "two/two.py"],
        "observe": [{"one": {"every": 20}}, {"two": {"every": 20}}],
    }
    run = dpd.run(SCENE | both, progress=False)
    assert (run.one == 1).all() and (run.two == 2).all() and "helper" not in sys.modules
    (folder / "two" / "helper.py").write_text("V = 5\n")
    assert (dpd.run(SCENE | both, progress=False).two == 5).all()


@pytest.mark.parametrize("pages", [["evil.py"], [{"path": "evil.py", "sha256": ""}]])
def test_a_result_runs_no_file_that_it_does_not_pin(folder, pages):
    """Whatever its scene says."""
    (folder / "evil.py").write_text("open('harmed', 'w')\n")
    with pytest.raises(UserError, match=r"is damaged|a file of pages without its digest"):
        Scene.of_result(json.dumps(SCENE | {"pages": pages}), "run.nc")
    assert not (folder / "harmed").exists()


def test_a_page_changes_nothing_but_its_own(folder):
    """What it sees cannot be written to; names of other observables cannot be taken."""
    (folder / "mine.py").write_text(
        PAGE.replace("return 2", "now.images[...] = 0\n        return 2")
    )
    with pytest.raises(UserError, match=r"line 14: ValueError: .*read-only"):
        dpd.run(SCENE | {"pages": ["mine.py"]}, progress=False)
    (folder / "mine.py").write_text(PAGE.replace('"neighbours": ((', '"kT": (('))
    own = {"pages": ["mine.py"], "observe": ["thermo", {"neighbours": {"every": 20}}]}
    with pytest.raises(UserError, match="'kT' is a variable of another observable"):
        dpd.run(SCENE | own, progress=False)


def test_pairs_do_not_reach_through_walls(folder):
    """Along an axis that ends no images are near; nothing is within no distance."""
    walled = {"walls": {"axis": "z", "repulsion": 25}, "box": [8, 8, 5], "pages": ["mine.py"]}
    far = {"observe": ["configuration", {"neighbours": {"within": 3.9, "every": 20}}]}
    run = dpd.run(SCENE | walled | far, progress=False)
    x = run.position.values
    apart = x[:, :, None] - x[:, None]
    apart[:2] -= 8 * np.round(apart[:2] / 8)
    by_hand = ((apart**2).sum(axis=0) < 3.9**2).sum() / x.shape[1] - 1
    assert float(run.neighbours[-1]) == pytest.approx(by_hand, rel=1e-12)


def test_keys_of_sections(folder):
    """Of a page of one's own as of ours; a name that is near."""
    own = command("keys", "neighbours", "--page", "mine.py").stdout
    assert "observe[].neighbours.within: number > 0, <= 5 [r_c]; if not given: 0.8" in own
    wrong = command("keys", "wals")
    assert wrong.returncode == 1 and "did you mean 'walls'?" in wrong.stderr


def test_the_schema_for_editors(folder):
    """All example scenes fit to it, a page of one's own too; misspelled keys do not."""
    printed = command("schema", "--page", "mine.py")
    check = jsonschema.Draft202012Validator(json.loads(printed.stdout)).is_valid
    for path in (PACKAGE / "scenes").glob("*.yaml"):
        assert check(read_yaml(path)) and Scene.read(path).beads > 0, path
    for stiffness in (4, {"from": 4, "to": 8}):
        assert check(SCENE) and check(SCENE | {"bond": {"A B": {"stiffness": stiffness}}})
    for wrong in (
        {"boxx": 4}, {"box": "4"}, {"walls": {"axis": "z"}}, {"thermostat": {"kT": {"to": 2}}},
        {"observe": [{"neighbours": {"within": 9}}]}, {"integrator": {"scheme": "leapfrog"}},
    ):  # fmt: skip
        assert not check(SCENE | wrong), wrong
    assert not check({key: value for key, value in SCENE.items() if key != "repulsion"})
