"""What is in the place of a result stays, unless a person asks for something else."""

import os
import shlex
from pathlib import Path
from unittest.mock import Mock

import netCDF4
import numpy as np
import pytest
import yaml

import dpd as package
from dpd import files
from dpd.commands.main import main
from dpd.errors import Occupied
from dpd.runs.result import checkpoint_path
from tests.conftest import SCENE, python

LONGER = SCENE | {"steps": {"equilibrate": 20, "sample": 300}}
EDITED = SCENE | {"seed": 2}
FOLLOWED = SCENE | {"observe": ["thermo", {"trajectory": {"every": 5}}]}


def write(name, scene):
    """A scene in a file."""
    Path(name).write_text(yaml.safe_dump(scene))


def contents():
    """All files here by name."""
    return {str(path): path.read_bytes() for path in Path().rglob("*") if path.is_file()}


def assert_refused(dpd, *command, words):
    """In one sentence, with the line to type, nothing changed; that line then does it."""
    before = contents()
    code, said = dpd(*command)
    assert code == 1 and said.count("\n") == 1 and words in said, said
    assert contents() == before
    line = said.strip().rpartition("to replace it: ")[2]
    again = shlex.split(line.removeprefix("python -m dpd "))
    assert again == [*map(str, command), "--overwrite"]
    assert main(again) == 0
    assert contents() != before


@pytest.fixture
def done(folder, dpd):
    """The result of the scene."""
    assert dpd("run", "scene.yaml", "-o", "run.nc")[0] == 0
    return Path("run.nc")


def test_a_result_of_the_same_scene_is_kept(done, dpd, monkeypatch):
    """One of another version too, which is said."""
    before = contents()
    code, said = dpd("run", "scene.yaml", "-o", "run.nc")
    assert code == 0 and "run.nc: is there already, of the same scene; it is kept" in said
    monkeypatch.setattr("dpd.runs.result.run_sources", lambda scene: "another")
    code, said = dpd("run", "scene.yaml", "-o", "run.nc")
    assert code == 0 and "same scene, made by another version of this program; it is kept" in said
    assert contents() == before


@pytest.mark.parametrize("what", ["edited", "longer", "damaged", "no NetCDF"])
def test_anything_else_is_refused(done, dpd, what):
    """With the whole line that replaces it."""
    if what == "edited":
        write("scene.yaml", EDITED)
        words = "holds the result of another scene, with other values of seed"
    elif what == "longer":
        assert dpd("extend", "run.nc", "--sample", "100")[0] == 0
        words = "with other values of steps (`dpd extend` makes a result longer)"
    else:
        os.truncate("run.nc", 5000) if what == "damaged" else done.write_text("notes")
        words = "run.nc: is there already, and cannot be read"
    assert_refused(dpd, "run", "scene.yaml", "-o", "run.nc", words=words)


def test_a_trajectory_is_not_lost(folder, dpd):
    """One without its result, nor a result without its trajectory."""
    write("scene.yaml", FOLLOWED)
    command = ("run", "scene.yaml", "-o", "run.nc")
    assert dpd(*command)[0] == 0
    os.rename("run.nc", "kept.nc")
    assert_refused(dpd, *command, words="run.gsd: is there already")
    os.remove("run.gsd")
    assert_refused(dpd, *command, words="run.nc: is there already, but not run.gsd")


def stop(*command, where="Checkpoint.discard", first="pass"):
    """A command in a process of its own that is killed where it calls a function."""
    program = (
        f"import os, sys, dpd.engine.loop as module; own = module.{where}\n"
        f"def end(*arguments): {first}; os._exit(9)\n"
        f"module.{where} = end\nfrom dpd.commands.main import main; main(sys.argv[1:])"
    )
    done = python("-c", program, *command)
    assert done.returncode == 9, done.stderr


@pytest.mark.parametrize("what", ["another scene", "another version"])
def test_the_state_of_another_run_is_not_lost(folder, dpd, monkeypatch, what):
    """That may be days of work; only when asked a run begins anew in its place."""
    write(scene := "long.yaml", SCENE | {"steps": {"equilibrate": 20, "sample": 2000}})
    stop(
        "run", scene, "-o", "run.nc", "--checkpoint-every", "0", where="Checkpoint.save",
        first="own(*arguments)",
    )  # fmt: skip
    if what == "another scene":
        write(scene := "scene.yaml", EDITED)
    else:
        monkeypatch.setattr("dpd.runs.result.run_sources", lambda scene: "another")
    assert dpd("run", scene, "-o", "run.nc")[0] == 1  # which takes over the lock
    assert_refused(dpd, "run", scene, "-o", "run.nc", words=what)
    assert not Path("run.checkpoint").exists()


def test_a_run_that_goes_on_asks_for_nothing(folder, dpd):
    """Killed in the middle, or after its result; also in the place of another."""
    write("long.yaml", LONGER | {"observe": FOLLOWED["observe"]})
    stop("run", "long.yaml", "-o", "run.nc", where="Checkpoint.save", first="own(*arguments)")
    left = ["run.checkpoint", "run.nc.lock", "run.nc.progress", "run.unfinished.gsd"]
    assert sorted(os.listdir()) == ["long.yaml", *left, "scene.yaml"]  # no trajectory yet
    code, said = dpd("run", "long.yaml", "-o", "run.nc")
    assert code == 0 and "anew" not in said
    os.remove("run.gsd")
    write("long.yaml", LONGER | {"seed": 3})
    stop("run", "long.yaml", "-o", "run.nc", "--overwrite", "--checkpoint-every", "0")
    assert Path("run.checkpoint").exists()
    code, said = dpd("run", "long.yaml", "-o", "run.nc")
    assert code == 0 and "it is kept" in said
    assert sorted(os.listdir()) == ["long.yaml", "run.nc", "scene.yaml"]


@pytest.mark.parametrize("every", [0, 60])
def test_an_extension_killed_after_its_result_is_not_made_twice(done, dpd, every):
    """Whether it has kept its state on its way or not."""
    command = ("extend", "run.nc", "--sample", "100", "--checkpoint-every", str(every))
    stop(*command)
    assert files.attributes("run.nc")["steps"] == 320
    write("other.yaml", EDITED)
    assert dpd("run", "other.yaml", "-o", "run.nc")[0] == 1
    code, said = dpd(*command)
    assert code == 0 and "has been made longer before" in said, said
    assert files.attributes("run.nc")["steps"] == 320 and not checkpoint_path("run.nc").exists()
    assert dpd(*command)[0] == 0 and files.attributes("run.nc")["steps"] == 420


@pytest.mark.parametrize("what", ["overwrite", "extend"])
def test_a_result_and_the_trajectory_beside_it_are_of_one_run(folder, dpd, monkeypatch, what):
    """Killed between the two, the same command goes on; that of a shorter run stays till then."""
    write("scene.yaml", FOLLOWED)
    write("other.yaml", FOLLOWED | {"seed": 2})
    assert dpd("run", "scene.yaml", "-o", "run.nc")[0] == 0
    command, steps = ("run", "other.yaml", "-o", "run.nc", "--overwrite"), 220
    if what == "extend":
        command, steps = ("extend", "run.nc", "--sample", "100"), 320
    with monkeypatch.context() as patch:
        patch.setattr(files, "write", Mock(side_effect=KeyboardInterrupt))
        assert dpd(*command)[0] == 130
    if what == "extend":
        assert files.attributes("run.nc")["steps"] == 220
    else:
        code, said = dpd("run", "scene.yaml", "-o", "run.nc")
        assert code == 1 and "holds the state of a run that was stopped or killed" in said
    code, said = dpd(*(each for each in command if each != "--overwrite"))
    assert code == 0 and "anew" not in said and files.attributes("run.nc")["steps"] == steps


def test_what_a_longer_run_would_replace(done, dpd):
    """Another result; the same one is kept."""
    command = ("extend", "run.nc", "--sample", "100", "-o", "longer.nc")
    assert dpd(*command)[0] == 0
    before = contents()
    assert "longer.nc: is there already, of the same scene" in dpd(*command)[1]
    assert contents() == before
    assert_refused(dpd, *command[:3], "50", *command[4:], words="other values of steps")


def test_what_other_commands_write(folder, dpd):
    """A configuration in the place of a trajectory; a picture whose name nobody gave."""
    write("scene.yaml", FOLLOWED)
    assert dpd("run", "scene.yaml", "-o", "run.nc")[0] == 0
    assert_refused(dpd, "convert", "run.nc", "run.gsd", words="run.gsd: is there already")
    Path("run.png").write_text("mine")
    assert_refused(dpd, "draw", "run.nc", words="run.png: is there already")
    assert dpd("draw", "run.nc", "-o", "run.png") == (0, "")


def test_from_python(done):
    """The same, with a warning or an argument."""
    with pytest.warns(UserWarning, match="is there already, of the same scene; it is kept"):
        kept = package.run(SCENE, output="run.nc", progress=False)
    before = done.read_bytes()
    with pytest.raises(package.UserError, match=r"another scene.* seed; overwrite=True replaces"):
        package.run(EDITED, output="run.nc", progress=False)
    assert done.read_bytes() == before
    other = package.run(EDITED, output="run.nc", progress=False, overwrite=True)
    assert not np.array_equal(other.kT, kept.kT)


def test_sweeps(folder):
    """Runs of an edited scene are refused before one begins; of another version they are kept."""
    axes = {"repulsion.A A": [15, 25]}
    first = package.sweep(SCENE, axes, output="runs", progress=False)
    runs = sorted(Path("runs").rglob("run.nc"))
    before = contents()
    with pytest.raises(Occupied, match=r"runs/.*/run.nc: holds the result of another scene"):
        package.sweep(SCENE | {"steps": LONGER["steps"] | {"equilibrate": 0}}, axes, output="runs")
    assert contents() == before
    for other in ({"repulsion.A A": [25]}, {"integrator.dt": [0.04]}):
        with pytest.raises(Occupied, match=r"sweep.nc: holds a sweep with other axes or values"):
            package.sweep(SCENE, other, output="runs", progress=False)
    assert contents() == before
    with netCDF4.Dataset(runs[0], "a") as file:
        file.sources = "another"
    with pytest.warns(UserWarning, match="made by another version of this program; it is kept"):
        second = package.sweep(SCENE, axes, output="runs", progress=False)
    assert second.pressure.equals(first.pressure)
    package.sweep(EDITED, axes, output="runs", progress=False, overwrite=True)
    assert files.attributes(runs[0])["sources"] != "another"
