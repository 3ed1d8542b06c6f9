"""Imports run one way: every room of the house stands on those below it."""

import ast
import re
from itertools import chain

import pytest
import yaml

from dpd.folders import PACKAGE, ROOT
from tests.conftest import SCENE, python

MOST_OF_A_RUN = 61  # modules that `dpd run` imports

# From the top. A room may import itself and what stands in lower rows, not its neighbours in a row.
ORDER = (
    ("__main__",),
    ("commands",),
    ("api", "report"),
    ("pipeline",),
    ("runs",),
    ("lammps",),
    ("analysis", "start", "observe"),
    ("particles",),
    ("scene", "engine"),
    ("physics",),
    ("jit", "page.own"),
    ("digests",),
    ("page",),
    ("files",),
    ("folders", "errors", "theory"),
)
ROWS = {room: row for row, rooms in enumerate(ORDER) for room in rooms}
# What a figure of a paper is made of; a picture of chains measures them as runs do.
FOR_FIGURES = {"analysis", "report", "theory", "errors", "observe", "page", "scene"}


def room_of(module):
    """The longest name in `ORDER` that a module, without ``dpd.``, begins with."""
    parts = module.split(".")
    names = (".".join(parts[:length]) for length in range(len(parts), 0, -1))
    return next((name for name in names if name in ROWS), None)


def imported(path):
    """Modules of the package that a file imports, without ``dpd.``; and names in modules."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, f"{path}: imports are absolute here"
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        else:
            continue
        yield from (name.removeprefix("dpd.") for name in names if name.startswith("dpd."))


MODULES = {
    ".".join(path.relative_to(PACKAGE).with_suffix("").parts).removesuffix(".__init__"): path
    for path in sorted(PACKAGE.rglob("*.py"))
    if path != PACKAGE / "__init__.py"  # what it hands on may come from anywhere
}


def test_every_module_has_a_room():
    """And no room is empty."""
    assert {room_of(module) for module in MODULES} == set(ROWS)


@pytest.mark.parametrize("module", MODULES)
def test_imports_go_down(module):
    """Also those inside of functions."""
    own = room_of(module)
    up = {
        name for name in imported(MODULES[module])
        if room_of(name) != own and ROWS[room_of(name)] <= ROWS[own]
    }  # fmt: skip
    assert not up, f"dpd.{module} stands below, or beside, what it imports: {', '.join(sorted(up))}"


def test_what_measures_speed_is_no_part_of_the_package():
    """It has commands of its own."""
    text = "".join(path.read_text() for path in MODULES.values())
    assert not re.search(r"^\s*(from|import) benchmarks", text, re.M)


def test_a_scene_knows_no_term():
    """Nor an engine: what is simulated does not know how; it finds its pages by their keys."""
    rooms = [module for module in MODULES if room_of(module) == "scene"]
    names = set(chain.from_iterable(imported(MODULES[module]) for module in rooms))
    assert not any(name.startswith(("engine", "physics")) for name in names)


def test_a_plan_needs_no_numba():
    """Nor xarray: Snakemake reads studies and digests in every process that it starts."""
    program = "import sys, dpd.pipeline.paper, dpd.digests; print(*sys.modules)"
    done = python("-c", program)
    assert done.stdout and not {"numba", "xarray", "matplotlib"} & set(done.stdout.split())


def test_a_run_imports_few_modules(tmp_path):
    """What a fluid needs, and no more: whoever reads how it runs reads these."""
    scene = tmp_path / "scene.yaml"
    scene.write_text(yaml.safe_dump(SCENE))
    program = (
        "import os, sys; end = os._exit; "
        "os._exit = lambda code: (print(*sys.modules, flush=True), end(code)); "
        "from dpd.__main__ import command; command()"
    )
    done = python("-c", program, "run", scene, "-o", tmp_path / "run.nc")
    assert done.returncode == 0, done.stderr
    found = [name for name in done.stdout.split() if name == "dpd" or name.startswith("dpd.")]
    assert len(found) <= MOST_OF_A_RUN, sorted(found)


@pytest.mark.parametrize(
    "first", [("numba", "dpd.physics.common.forces"), ("dpd.physics.common.forces", "numba")]
)
def test_whoever_imports_numba_first_it_has_our_settings(first):
    """The folder of kernels, and the level of optimisation, on which the last bits depend."""
    program = (
        f"import {', '.join(first)}, os; from numba import config; "
        "print(int(config.OPT), config.CACHE_DIR == os.environ['NUMBA_CACHE_DIR'])"
    )
    assert python("-c", program).stdout.split() == ["1", "True"]


@pytest.mark.parametrize(
    "paper", sorted({path.parent.name for path in ROOT.glob("paper_figures/*/*.py")})
)
def test_figures_import_what_is_for_them(paper):
    """Analysis, theory and looks, scenes, settings; observables the engine, calculations starts."""
    for path in (ROOT / "paper_figures" / paper).glob("*.py"):
        rooms = {room_of(name) for name in imported(path)}
        allowed = FOR_FIGURES | ({"engine"} if "(Observable, key=" in path.read_text() else set())
        allowed |= {"engine", "start"} if path.stem == "calculations" else set()
        assert rooms <= allowed, f"{path.name}: {rooms - allowed}"
