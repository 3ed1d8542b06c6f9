"""Digests of sources: what an edit changes, and what it leaves alone."""

import json

import pytest

from dpd.digests import DECIDE_NOTHING, STAGES, file_of, reachable, source_of, unused
from dpd.folders import PACKAGE
from dpd.page import Observable, names
from dpd.pipeline.paper import read_config, read_paper
from tests.conftest import python
from tests.test_pipeline import copy_repository

CODE = '''"""What it is for."""
import numpy as np
from dpd.errors import UserError


def double(x):
    """Twice."""
    return 2 * x  # fast
'''
SAME = {
    "comment": CODE.replace("# fast", "# faster"),
    "docstring of the module": CODE.replace("What it is for", "What else"),
    "docstring of a function": CODE.replace('    """Twice."""\n', ""),
    "blank lines": CODE.replace("\n\n\n", "\n\n\n\n\n"),
    "type hints": CODE.replace("double(x)", "double(x: float) -> float"),
    "imports for type hints": CODE.replace(
        "import numpy as np\n",
        "from __future__ import annotations\nfrom typing import TYPE_CHECKING\n"
        "import numpy as np\nif TYPE_CHECKING:\n    from pathlib import Path\n",
    ),
    "form": CODE.replace("2 * x", "(2\n        * x)"),
}
PAGE = (
    CODE
    + """

class Page:
    stands = {1}
    cannot = {2: "stands still"}
    bin: float = setting("Bin width.", 0.02, gt=0)

    def refuses(self):
        yield "", "there is none"
"""
)
OTHER = {
    "number": CODE.replace("2 * x", "3 * x"),
    "kind of number": CODE.replace("2 * x", "2.0 * x"),
    "name": CODE.replace("double", "twice"),
    "field of a record": CODE.replace("def double", "x: int\n\ndef double"),
    "condition": CODE.replace("import numpy as np\n", "if np:\n    import numpy as np\n"),
    "import": CODE.replace("import numpy as np\n", ""),
    "text that is no docstring": CODE.replace("return 2 * x", "'Twice.'; return 2 * x"),
}


@pytest.mark.parametrize("change", [*SAME, *OTHER])
def test_what_counts_of_a_file(tmp_path, change):
    """Code does; comments, docstrings and form do not."""
    paths = tmp_path / "before.py", tmp_path / "after.py"
    for path, text in zip(paths, (CODE, (SAME | OTHER)[change])):
        path.write_text(text)
    before, after = map(source_of, paths)
    assert (before.digest == after.digest) == (change in SAME)
    assert file_of("dpd.errors") in before.imports


def test_what_a_page_refuses_does_not_count(tmp_path):
    """Nor what it stands, why not the rest, and how settings are worded; their defaults do."""
    found = set()
    changes = [("", ""), ("{1}", "{1, 3}"), ("still", "up"), ("none", "1"), ("Bin w", "W")]
    for number, (old, new) in enumerate(changes):
        path = tmp_path / f"{number}.py"
        path.write_text(PAGE.replace(old, new) if old else PAGE)
        found.add(source_of(path).digest)
    assert len(found) == 1
    for number in (2, 3):  # such names elsewhere are code as any other
        path = tmp_path / f"cannot {number}.py"
        path.write_text(f"def half():\n    cannot = {number}\n    return cannot\n")
        found.add(source_of(path).digest)
    assert len(found) == 3
    path.write_text(PAGE.replace("0.02", "1"))
    assert source_of(path).digest not in found


def test_data_files_and_files_that_are_no_python(tmp_path):
    """What a module says that it reads counts with it; a broken file counts as it is."""
    (tmp_path / "page.html").write_text("one")
    for name in ("one.py", "two.py"):
        (tmp_path / name).write_text('PAGE = "page.html"\n')
    one = source_of(tmp_path / "one.py")
    (tmp_path / "page.html").write_text("two")
    assert source_of(tmp_path / "two.py").digest != one.digest
    for name in ("three.py", "four.py"):
        (tmp_path / name).write_text(f"def {name}")
    assert source_of(tmp_path / "three.py").digest != source_of(tmp_path / "four.py").digest


IMPORTED = """
import importlib, json, sys
for name in sys.argv[1:]:
    importlib.import_module(name)
ours = "dpd", "benchmarks"
modules = [module for name, module in sys.modules.items() if name.split(".")[0] in ours]
print(json.dumps([module.__file__ for module in modules]))
"""


@pytest.mark.few(1)
@pytest.mark.parametrize("stage", STAGES)
def test_all_that_a_stage_imports_is_found(stage):
    """Compared with what Python has in fact imported; functions may import more, later."""
    done = python("-c", IMPORTED, *STAGES[stage])
    assert set(json.loads(done.stdout)) <= set(map(str, reachable(STAGES[stage])))
    assert all(file_of(name) for name in DECIDE_NOTHING)


def test_who_imports_what_a_scene_may_lack():
    """Observables alone each other, what computes forces their terms: others would forget them."""

    def users(files, paths):
        for path in paths:
            if files & (source_of(path).imports - {path}):
                yield str(path.relative_to(PACKAGE))

    pages = [f"dpd.observe.{name}" for name in names(Observable)]
    files = {file_of(page) for page in pages}
    assert not set(users(files, reachable(STAGES["simulate"])))
    assert set(users(files, reachable(tuple(pages)))) == {"observe/diffusion.py"}
    users_of_terms = set(users(unused(frozenset()), reachable(STAGES["simulate"])))
    rooms = {user.split("/")[0] for user in users_of_terms}
    assert rooms <= {"engine", "particles", "physics", "start", "scene"}


DIGESTS = """
import json, sys
from dpd.pipeline.paper import read_paper
from dpd.analysis.verdicts import figure_path
from dpd.digests import kernel_digest
from dpd.digests import STAGES, kernels_name, run_sources, stage_digest
from dpd.digests import start_sources
found = {f"stage {stage}": stage_digest(stage) for stage in STAGES} | {"kernels": kernel_digest()}
for name in sys.argv[1:]:
    paper = read_paper(name, "smoke")
    for figure in paper.figures:
        found[f"figure {name} {figure}"] = stage_digest("figure", figure_path(name, figure))
    for sweep in paper.sweeps.values():
        for point in sweep.points:
            found[f"run {name} {sweep.name} {point.name}"] = run_sources(point.scene)
            found[f"start {name} {sweep.name} {point.name}"] = start_sources(point.scene)
            found[f"compile {name} {sweep.name} {point.name}"] = kernels_name(point.scene)
print(json.dumps(found))
"""
PAPERS = read_config()["papers"]


def digests(folder):
    """All digests of a copy of the repository, in a process of its own."""
    done = python("-c", DIGESTS, *PAPERS, PYTHONPATH=str(folder / "src"))
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """A copy whose files may be edited, and its digests."""
    folder = copy_repository(tmp_path_factory.mktemp("copy"))
    return folder, digests(folder)


def changed(copy, name):
    """Names of what an edited file of the copy changes."""
    folder, before = copy
    text = (folder / name).read_text()
    (folder / name).write_text(f"{text}\nEDITED = 1\n")
    after = digests(folder)
    (folder / name).write_text(text)
    assert after.keys() == before.keys()
    return {name for name in before if before[name] != after[name]}


def runs(has):
    """Names of the runs of the smoke study whose scenes have something."""
    return {
        f"run {name} {sweep.name} {point.name}"
        for name in PAPERS
        for sweep in read_paper(name, "smoke").sweeps.values()
        for point in sweep.points
        if has(point.scene)
    }


def of_kind(names, *kinds):
    """Those whose first word is one of some."""
    return {name for name in names if name.split()[0] in kinds}


FIGURE_OF_CHAINS = "figure liu_2008 fig04_snapshot"


@pytest.mark.parametrize(
    ("module", "has"),
    [
        ("engine/neighbours", lambda scene: True),
        ("observe/crossings", lambda scene: "crossings" in scene.observe),
        ("physics/pressure", lambda scene: "pressure" in scene.terms),  # starts keep their box
        ("analysis/interfaces", lambda scene: False),
    ],
)
def test_an_edit_changes_what_it_decides(copy, module, has):
    """Runs, starts and kernels of the scenes that have it, the figures that use it; no more."""
    names, expected = changed(copy, f"src/dpd/{module}.py"), runs(has)
    room = module.split("/")[0]
    assert of_kind(names, "run") == expected
    compiled = {name.replace("compile", "run") for name in of_kind(names, "compile")}
    assert compiled == (expected if room in ("engine", "physics") else set())
    assert ("kernels" in names) == (room in ("engine", "physics"))
    assert len(of_kind(names, "start")) == (len(expected) if room == "engine" else 0)
    figures = of_kind(names, "figure") - {FIGURE_OF_CHAINS}
    assert ("figure groot_warren_1997 fig06_interface" in figures) == (room == "analysis")
    assert not any("nikunen" in name or "liu" in name for name in figures)
