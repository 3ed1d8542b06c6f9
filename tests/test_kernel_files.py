"""Compiled kernels on the disk are those of their arguments, whoever else compiles meanwhile."""

import os
import subprocess
import sys

import pytest

from dpd.folders import PACKAGE

DOUBLE = """
import dpd.jit
from dpd.jit import kernel

@kernel()
def double(x):
    return x + x
"""

# Writes only when the other process is about to write as well: both have looked by then what is
# there.
COMPILE = """
import sys, time
from pathlib import Path
from numba.core.caching import IndexDataCacheFile
from double import double

write = IndexDataCacheFile._open_for_write

def both_at_once(self, *arguments):
    mine, other = map(Path, sys.argv[2:])
    mine.touch()
    end = time.monotonic() + 60
    while not other.exists() and time.monotonic() < end:
        time.sleep(0.01)
    return write(self, *arguments)

IndexDataCacheFile._open_for_write = both_at_once
print(double(eval(sys.argv[1])))
"""

USE = """
from double import double
print([double(2), double(2.5)], sum(double.stats.cache_hits.values()))
"""


@pytest.fixture
def python(tmp_path):
    """A function that starts a Python with a kernel and an empty cache of its own."""
    (tmp_path / "double.py").write_text(DOUBLE)
    environment = os.environ | {
        "PYTHONPATH": f"{tmp_path}:{PACKAGE.parent}",
        "XDG_CACHE_HOME": str(tmp_path / "cache"),
    }
    environment.pop("NUMBA_CACHE_DIR", None)

    def start(code, *arguments):
        return subprocess.Popen(
            [sys.executable, "-c", code, *arguments],
            env=environment, cwd=tmp_path, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip

    return start


def answer(process):
    """What a process printed; it ended well."""
    printed, _ = process.communicate(timeout=600)
    assert process.returncode == 0
    return printed.strip()


@pytest.mark.thorough
def test_two_processes_write_at_the_same_time(python, tmp_path):
    """Numba's own files would both be number 1, and its index would know one of them."""
    both = [python(COMPILE, "2", "a", "b"), python(COMPILE, "2.5", "b", "a")]
    assert [answer(process) for process in both] == ["4", "5.0"]
    assert answer(python(USE)) == "[4, 5.0] 2"


WATCH = """
from dpd.jit import COMPILING
said = []
COMPILING.tell = said.append
from double import double
print([double(2), double(2.5)], said, COMPILING.duration > 0)
"""


def test_compiling_is_said_once(python):
    """And counted; what is read from the disk is not compiled."""
    assert answer(python(WATCH)) == "[4, 5.0] ['compiling, once for this kind of scene'] True"
    assert answer(python(WATCH)) == "[4, 5.0] [] False"


FIRST = """
from dpd.pipeline.paper import read_paper
papers = ("nikunen_2007", "passes"), ("liu_2008", "melts"), ("groot_warren_1997", "stress")
points = [read_paper(paper, "smoke", [sweep]).sweeps[sweep].points[0] for paper, sweep in papers]
"""

COMPILE_ALL = f"""{FIRST}
from dpd.pipeline.jobs import compile_for
compile_for([point.scene for point in points])
"""

RUN = f"""{FIRST}
from dpd.engine.loop import run
from dpd.engine.simulation import Simulation
from dpd.observe.common.measured import observables
from dpd.start.common.make import compile_start, system_of
for point in points:
    scene, system = point.scene, system_of(point.scene)
    simulation = Simulation(system, compile_start(scene))
    run(simulation, (500, 900), observables(scene, system))
"""


@pytest.mark.thorough
def test_runs_compile_nothing_after_kernels_were_compiled(python, tmp_path):
    """Also where an observable compares each sample with the one before."""
    answer(python(COMPILE_ALL))
    before = set((tmp_path / "cache").rglob("*.nbc"))
    assert before
    answer(python(RUN))
    assert set((tmp_path / "cache").rglob("*.nbc")) == before
