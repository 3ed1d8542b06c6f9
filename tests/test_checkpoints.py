"""What a run resumes from has a checksum, and what it cannot write is no reason to lose it."""

import json
import os
import resource
from contextlib import contextmanager

import numpy as np
import pytest
import yaml

from dpd import jit
from dpd.engine.checkpoint import MARK, Checkpoint, checksum_of, stored_in
from dpd.engine.loop import run
from dpd.engine.simulation import Simulation
from dpd.errors import UserError
from dpd.jit import kernel
from dpd.observe.common.measured import observables
from dpd.pipeline.paper import read_paper
from dpd.runs.result import refuse_to_lose
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start, system_of

SCENE = {
    "dimension": 2,
    "box": 5,
    "molecules": [{"architecture": "A 2 B", "count": 20}],
    "repulsion": {"A A": 25, "A B": 30, "B B": 25},
    "bond": {"stiffness": 20, "length": 0.4},
    "integrator": {"scheme": "gw-vv", "dt": 0.004},
    "steps": {"equilibrate": 20, "sample": 700},
    "observe": [
        "thermo", {"rdf": {"range": 2, "every": 10}}, {"displacement": {"every": 5}},
        {"crossings": {"every": 5}}, {"configuration": {"every": 100}},
        {"trace": {"every": 10}},
    ],
}  # fmt: skip
KEY = {"scene": "this"}


def new_run():
    """A simulation with a pair list, and its observers, at their beginning."""
    scene = Scene(SCENE)
    system = system_of(scene)
    assert system.skin > 0
    return Simulation(system, make_start(scene)), observables(scene, system)


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """Arrays of a checkpoint after 220 steps."""
    checkpoint = Checkpoint(tmp_path_factory.mktemp("good") / "run.checkpoint", KEY)
    simulation, observers = new_run()
    run(simulation, (20, 200), observers)
    assert checkpoint.save(simulation, observers) == ""
    with np.load(checkpoint.path) as file:
        return dict(file)


def resumed(arrays, path):
    """What a run says of a checkpoint of some arrays, and the step at which it then is."""
    with open(path, "wb") as file:
        np.savez(file, **arrays)
    simulation, observers = new_run()
    said = Checkpoint(path, KEY).resume(simulation, observers)
    return said, simulation.state.step


def test_a_good_one_is_taken(good, tmp_path):
    """So that the tests below can fail."""
    assert resumed(good, tmp_path / "run.checkpoint") == ("", 220)


def test_a_note_beside_the_state(good, tmp_path):
    """It comes back whole, or not at all; the state does not depend on it."""
    path = tmp_path / "run.checkpoint"
    assert stored_in(path) is None
    for note in (None, {"dt": 0.06, "said": "a step"}):
        simulation, observers = new_run()
        assert Checkpoint(path, KEY, note).save(simulation, observers) == ""
        assert stored_in(path).note == (note or {})
        assert Checkpoint(path, KEY).resume(simulation, observers) == ""
    step, jump = (text.encode("utf-32-le") for text in ("a step", "a jump"))
    data = path.read_bytes()
    path.write_bytes(data.replace(step, jump))
    assert step in data and stored_in(path) is None
    assert resumed(good, path) == ("", 220)


NAMES = (
    "step", "position", "velocity", "force", "identity", "species", "reference", "0/taken", "0/kT",
    "1/rdf", "1/taken", "2/earlier", "2/begun", "2/taken", "3/crossings", "3/pairs", "4/position",
    "5/trace", "image",
)  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_any_edit_is_seen(good, tmp_path, name):
    """One value of one array, changed by the least there is: the checksum does not fit."""
    arrays = {key: array.copy() for key, array in good.items()}
    flat = arrays[name].reshape(-1).view(np.uint8)
    flat[0] ^= 1
    said, step = resumed(arrays, tmp_path / "run.checkpoint")
    assert "damaged" in said and "starting anew" in said and step == 0


def test_one_of_a_version_without_image_counts_stays(good, tmp_path):
    """It may be all that there is of a long run: what to do is said, and nothing else done."""
    arrays = {name: array for name, array in good.items() if name not in ("image", "checksum")}
    scene, path = Scene(SCENE), tmp_path / "run.checkpoint"
    arrays[MARK] = np.array(json.dumps({"scene": scene.digest, "sources": "those of 0.2"}))
    arrays["note"] = np.array(json.dumps({"scene": json.dumps(scene.data)}))
    sealed = arrays | {"checksum": np.array(checksum_of(arrays))}
    assert resumed(sealed, path)[1] == 0  # where that is wanted
    with pytest.raises(UserError, match=r"another version .* 0.2, .*: finish the run with that"):
        refuse_to_lose(scene, path)
    assert path.exists()


@pytest.mark.parametrize("seed", range(12))
def test_damaged_bytes(good, tmp_path, seed):
    """Bytes changed, cut off or doubled anywhere: refused, taken as they were, or left alone."""
    path, rng = tmp_path / "run.checkpoint", np.random.default_rng(seed)
    with open(path, "wb") as file:
        np.savez(file, **good)
    data = bytearray(path.read_bytes())
    at = int(rng.integers(len(data)))
    if seed % 4 == 0:
        data = data[:at]
    elif seed % 4 == 1:
        data[at:at] = data[at : at + 1000]
    else:
        data[at] ^= 1 << int(rng.integers(8))
    path.write_bytes(data)
    simulation, observers = new_run()
    said = Checkpoint(path, KEY).resume(simulation, observers)
    assert (simulation.state.step == 220) == (said == "")


@contextmanager
def files_up_to(size):
    """The system refuses larger files, as a full disk does."""
    former = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, former[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, former)


def test_a_result_that_cannot_be_written_is_not_lost(folder, dpd):
    """The disk is full at the end: a sentence, and the last state is kept; then it goes on."""
    scene = yaml.safe_load((folder / "scene.yaml").read_text())
    scene["observe"] += [{"trace": {"every": 1}}]
    (folder / "scene.yaml").write_text(yaml.safe_dump(scene))
    code, errors = dpd("run", "scene.yaml", "-o", "run.nc")
    assert code == 0
    size = os.path.getsize("run.nc")
    os.remove("run.nc")
    with files_up_to(size // 2):
        code, errors = dpd("run", "scene.yaml", "-o", "run.nc")
    assert code == 1 and "run.nc: cannot be written (File too large)" in errors
    assert "Traceback" not in errors
    assert len(errors.splitlines()) == 1
    assert sorted(os.listdir()) in (["run.checkpoint", "scene.yaml"], ["scene.yaml"])
    assert dpd("run", "scene.yaml", "-o", "run.nc")[0] == 0
    assert sorted(os.listdir()) == ["run.nc", "scene.yaml"]


def test_a_cut_run_is_not_collected(tmp_path, monkeypatch, dpd):
    """A sentence that names the file and says what to do."""
    monkeypatch.chdir(tmp_path)
    sweep = read_paper("groot_warren_1997", "smoke", only=["fluid"]).sweeps["fluid"]
    runs = tmp_path / "runs"
    for point in sweep.points:
        path = runs / point.name / "run.nc"
        path.parent.mkdir(parents=True)
        with open(path, "wb") as file:
            file.write(b"\x89HDF\r\n\x1a\n" + bytes(500))
    code, errors = dpd(
        "collect", "smoke", "groot_warren_1997", "fluid", "--runs", runs, "-o", "sweep.nc"
    )
    assert code == 1 and "run.nc: not a whole NetCDF file" in errors and "Traceback" not in errors
    assert not (tmp_path / "sweep.nc").exists()


def test_a_full_cache_is_no_reason_not_to_run(monkeypatch):
    """A kernel that cannot be kept is compiled and runs; one sentence says so."""

    def full(*arguments):
        raise OSError(28, "No space left on device")

    @kernel()
    def twice(x):
        return 2 * x

    monkeypatch.setattr(twice._cache, "_save_overload", full, raising=False)
    monkeypatch.setattr(twice._cache, "_load_overload", full, raising=False)
    with pytest.warns(UserWarning, match="No space left") as said:
        assert twice(21) == 42
    assert len(said) == 1


def test_kernels_that_others_could_have_written_are_not_run(tmp_path, monkeypatch):
    """Nor kept: in a folder that is another's, or that all may write to."""
    trusts = jit._is_trusted.__wrapped__
    assert trusts(tmp_path / "kernels") and (tmp_path / "kernels").is_dir()
    for mode, owner in ((0o777, os.getuid()), (0o755, 12345)):
        (tmp_path / "kernels").chmod(mode)
        if os.getuid() == 0:
            os.chown(tmp_path / "kernels", owner, -1)
        elif owner != os.getuid():
            monkeypatch.setattr("os.getuid", lambda: 12345)
        jit._warn.cache_clear()
        with pytest.warns(UserWarning, match="another user can write there"):
            assert not trusts(tmp_path / "kernels")
    jit._warn.cache_clear()


def test_all_names_are_those_of_a_checkpoint(good):
    """The table above names arrays that are there."""
    assert set(NAMES) <= set(good) and MARK in good
