"""What tests of the command line share."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import yaml

from dpd.commands.main import main
from dpd.folders import ROOT
from dpd.jit import COMPILES

if not COMPILES:
    np.seterr(over="ignore")  # hashes and sets of bits overflow on purpose, which NumPy tells of

# Tests that are started in the background ignore Ctrl-C, and so would all commands that they start;
# so it is with nohup and a terminal that is closed.
for number, usual in ((signal.SIGINT, signal.default_int_handler), (signal.SIGHUP, signal.SIG_DFL)):
    if signal.getsignal(number) is signal.SIG_IGN:
        signal.signal(number, usual)

SCENE = {
    "dimension": 3,
    "box": 4,
    "molecules": [{"architecture": "A", "density": 3}],
    "repulsion": {"A A": 25},
    "integrator": {"scheme": "gw-vv", "dt": 0.04},
    "steps": {"equilibrate": 20, "sample": 200},
    "observe": ["thermo", {"rdf": {"range": 2, "every": 20}}],
}


def python(*words, cwd=None, **environment):
    """Python in a process of its own, with this package."""
    return subprocess.run(
        [sys.executable, *map(str, words)], cwd=cwd, capture_output=True, text=True, check=False,
        env=os.environ | {"PYTHONPATH": str(ROOT / "src")} | environment,
    )  # fmt: skip


def command(*arguments, **given):
    """A command in a process of its own."""
    return python("-m", "dpd", *arguments, **given)


def folder_with(files):
    """A fixture: a folder to work in, with files by name, a text or a scene in each."""

    @pytest.fixture
    def folder(tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        for name, content in files.items():
            text = content if isinstance(content, str) else yaml.safe_dump(content)
            (tmp_path / name).write_text(text)
        return tmp_path

    return folder


def documented(words):
    """The first block of Python behind some words in what is written on pages of one's own."""
    text = "\n".join(path.read_text() for path in sorted(ROOT.glob("docs/guide/*.md")))
    return re.search(f"{words}.*?```python\n(.*?)```", text, re.S)[1]


class Command(subprocess.Popen):
    """A process with this package, which does not outlive its ``with``: that would wait for it."""

    def __init__(self, *words):
        super().__init__(
            [sys.executable, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            env=os.environ | {"PYTHONPATH": str(ROOT / "src")},
        )  # fmt: skip

    def __exit__(self, *problem):
        self.kill()
        return super().__exit__(*problem)


def begin(*arguments):
    """A command on its way."""
    return Command("-m", "dpd", *arguments)


def wait_for(condition):
    """Until something holds; kernels may have to be compiled first."""
    end = time.monotonic() + 300
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def pytest_collection_modifyitems(items):
    """Mark what is left to `make thorough`: the smoke study, most cases of tests with many, and
    what is passed without the compiler."""
    cases = {}
    for item in items:
        if "study" in getattr(item, "fixturenames", ()):
            item.add_marker("thorough")
        if item.get_closest_marker("few"):
            cases.setdefault(item.nodeid.split("[")[0], []).append(item)
        elif item.get_closest_marker("plain"):
            item.add_marker("thorough")
    for same in cases.values():
        few = same[0].get_closest_marker("few").args
        if isinstance(few[0], int):  # so many from all over the table
            few = [same[i * len(same) // few[0]].callspec.id for i in range(few[0])]
        unknown = set(few) - {item.callspec.id for item in same}
        if unknown and len(same) > 1:
            raise pytest.UsageError(f"{same[0].nodeid}: no case {unknown} to take")
        for item in same:
            if item.callspec.id not in few:
                item.add_marker("thorough")


@pytest.fixture(scope="session")
def cache(tmp_path_factory):
    """A folder for kernels and for what is known to be valid, of these tests alone.

    Workers that share the tests share it.
    """
    base = tmp_path_factory.getbasetemp()
    shared = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    (shared / "cache").mkdir(exist_ok=True)
    return shared / "cache"


@pytest.fixture
def own_cache(tmp_path, monkeypatch):
    """Nothing is found valid because it was before, and nothing is left in the user's cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


@pytest.fixture
def folder(tmp_path, monkeypatch, cache):
    """A folder to work in, with a scene."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache))
    Path("scene.yaml").write_text(yaml.safe_dump(SCENE))
    return tmp_path


@pytest.fixture
def dpd(capsys):
    """A command in this process: its exit code and what it said on standard error.

    What it printed beside that is ``dpd.output``.
    """

    def command(*arguments):
        try:
            code = main([str(argument) for argument in arguments])
        except SystemExit as left:  # what argparse does
            code = left.code
        command.output, errors = capsys.readouterr()
        return code, errors

    return command
