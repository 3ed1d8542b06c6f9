"""Files of a user's own that are dropped into the package are the package's own."""

import os
import shutil
import subprocess
import sys

import yaml

from dpd.digest import PACKAGE
from dpd.files import read
from tests import test_bond_pages, test_own_forces, test_own_pages, test_own_starts

PAGES = {
    "physics/morse.py": test_own_forces.MORSE,
    "physics/quartic.py": test_bond_pages.QUARTIC,
    "observe/neighbours.py": test_own_pages.PAGE,
    "start/line.py": test_own_starts.PAGE,
}
SCENE = {
    "dimension": 3, "box": 4,
    "molecules": [{"architecture": "A 3", "density": 2}, {"architecture": "B", "density": 1}],
    "repulsion": {"A A": 25, "A B": 30, "B B": 20},
    "morse": {"depth": {"A A": 1, "A B": 0, "B B": 3}},
    "quartic": {"stiffness": 5, "fourth": 2},
    "start": {"method": "line", "step": 0.02},
    "integrator": {"scheme": "gw-vv", "dt": 0.001},
    "steps": {"sample": 4},
    "observe": [{"neighbours": {"every": 2}}],
}  # fmt: skip


def run(house, scene, result):
    """Run a scene with a package, without the compiler: what it does is the same."""
    done = subprocess.run(
        [sys.executable, "-m", "dpd", "run", scene, "-o", result], capture_output=True, text=True,
        env=os.environ | {"PYTHONPATH": str(house), "NUMBA_DISABLE_JIT": "1"}, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return read(result)[0]


def test_files_dropped_into_the_package_are_its_own(tmp_path, monkeypatch):
    """The same beads and numbers, and no scene has to name a file."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(PACKAGE, "house/dpd", ignore=shutil.ignore_patterns("__pycache__"))
    for name, text in PAGES.items():
        (tmp_path / "house" / "dpd" / name).write_text(text)
        (tmp_path / os.path.basename(name)).write_text(text)
    (tmp_path / "plain.yaml").write_text(yaml.safe_dump(SCENE))
    files = [os.path.basename(name) for name in PAGES]
    (tmp_path / "own.yaml").write_text(yaml.safe_dump(SCENE | {"pages": files}))
    own = run(PACKAGE.parent, "own.yaml", "own.nc")
    dropped = run("house", "plain.yaml", "dropped.nc")
    assert own["neighbours"].std() > 0
    for name in ("last_position", "last_velocity", "neighbours"):
        assert own[name].tobytes() == dropped[name].tobytes(), name
