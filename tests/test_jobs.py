"""Commands of the rules, as copies of one process."""

import os
import subprocess
import sys
from tempfile import mkdtemp

from tests.conftest import wait_for
from tests.test_pipeline import copy_repository


def test_commands_are_copies_of_one_process(tmp_path):
    """What they print and how they end gets through; edited sources are run as they are now."""
    folder, place = copy_repository(tmp_path / "copy"), mkdtemp()
    jobs = [sys.executable, folder / "rules" / "jobs.py"]
    own = os.environ | {"DPD_JOBS": f"{place}/jobs", "PYTHONPATH": str(folder / "src")}
    own |= {"OPENBLAS_NUM_THREADS": "1"}

    def call(*words):
        return subprocess.run(
            [*jobs, *words], env=own, cwd=tmp_path, capture_output=True, text=True, check=False
        )

    with subprocess.Popen([*jobs, "--serve", own["DPD_JOBS"]], stdin=-1, env=own) as server:
        wait_for(lambda: os.path.exists(own["DPD_JOBS"]))
        said, wrong = call("keys", "walls"), call("keys", "wals")
        assert said.returncode == 0 and "repulsion" in said.stdout and not said.stderr
        assert wrong.returncode == 1 and "walls" in wrong.stderr and server.poll() is None
        with open(folder / "src" / "dpd" / "commands" / "main.py", "a") as source:
            source.write("\nprint('edited')\n")
        assert "edited" in call("keys", "walls").stdout and server.wait(60) == 0
    assert not os.path.exists(place)
