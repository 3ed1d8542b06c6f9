"""What a newcomer stumbles over: a plain sentence at the moment of the mistake, and nothing lost."""

import re

import pytest

from dpd.errors import UserError
from dpd.scene import Scene
from dpd.study import merge
from tests.test_cli import SCENE, dpd, write

CHAINS = merge(
    SCENE,
    {
        "box": 10,
        "molecules": {0: {"architecture": "A 9", "density": 3}},
        "bond": {"stiffness": 4},
        "observe": ["thermo"],
    },
)


def test_a_density_that_chains_miss_by_little_is_noted(tmp_path):
    """333 chains of 9 beads make 2.997 instead of 3; a density that is met gets no note."""
    assert Scene(SCENE).notes == []
    scene = Scene(CHAINS)
    assert [density.found for density in scene.missed_densities] == [pytest.approx(2.997)]
    done = dpd("run", write(tmp_path / "scene.yaml", CHAINS), "-o", "run.nc", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (
        "333 molecules of 9 beads in a box of 10 x 10 x 10 make 2.997 instead of 3" in done.stdout
    )


@pytest.mark.parametrize("box", [4, [4, 4, 4.5]])
def test_a_density_that_chains_miss_by_much_is_refused(box):
    """With density, box and count; the box and the count that it proposes are allowed."""
    chains = merge(CHAINS, {"box": 4, "molecules": {0: {"architecture": "A 20"}}}) | {"box": box}
    with pytest.raises(
        UserError, match=r"molecules\.0\.density: 3 is not met: 1\d molec"
    ) as refused:
        Scene(chains)
    said = str(refused.value)
    proposed = re.search(r"Write 'box: (.+)', in which (\d+) .* or 'count: (\d+)'", said)
    edges, count, again = proposed.groups()
    assert count == again and " beads in a box of 4 x 4 x" in said
    edges = [float(edge) for edge in edges.strip("[]").split(", ")]
    fitting = Scene(chains | {"box": edges if isinstance(box, list) else edges[0]})
    assert fitting.density == pytest.approx(3, rel=1e-4)
    assert fitting.molecules[0].count == int(count)
    counted = Scene(chains | {"molecules": [{"architecture": "A 20", "count": int(count)}]})
    assert counted.density == pytest.approx(3, rel=0.1)


def test_a_result_given_as_a_start_is_called_so(tmp_path):
    """The message says what the file is and what is wanted; it never says to delete it."""
    scene = write(tmp_path / "scene.yaml", SCENE)
    assert dpd("run", scene, "-o", "finished.nc", cwd=tmp_path).returncode == 0
    before = (tmp_path / "finished.nc").read_bytes()
    for given, what in (("finished.nc", "this is the result of a run"), ("scene.yaml", "NetCDF")):
        done = dpd("run", scene, "--start", given, "-o", "new.nc", cwd=tmp_path)
        assert done.returncode == 1 and "Traceback" not in done.stderr
        assert f"error: {given}: " in done.stderr and what in done.stderr
        assert "delete" not in done.stderr
    assert (tmp_path / "finished.nc").read_bytes() == before
    assert not (tmp_path / "new.nc").exists()
