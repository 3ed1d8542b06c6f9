"""Pictures of beads and bonds: what is where in them, and what is refused."""

import os
import random
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
import yaml
from matplotlib import pyplot
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import rgb_to_hsv, to_rgb
from matplotlib.text import Text
from PIL import Image

from dpd import draw
from dpd.errors import UserError
from dpd.particles import read, write
from dpd.particles.particles import Particles
from dpd.report.style import BLUE, GREEN, ORANGE
from tests.conftest import SCENE

WHITE = (1.0, 1.0, 1.0)


def particles(position, box, species=None, bonds=(), names="ABC"):
    """Beads at rest; a row of ``position`` for each."""
    position = np.array(position, float).T
    beads = position.shape[1]
    return Particles(
        box=box, position=position, image=np.zeros(position.shape, np.int32), velocity=None,
        species=np.array(species or [0] * beads, np.uint8), names=tuple(names),
        bonds=np.array(bonds, np.uint32).reshape(-1, 2),
    )  # fmt: skip


class Picture:
    """The pixels of a figure."""

    def __init__(self, figure):
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        self.pixels = np.asarray(canvas.buffer_rgba())[..., :3] / 255
        self.figure = figure
        self.texts = [text.get_text() for text in figure.findobj(Text)]

    def at(self, x, y, panel=0):
        """The colour at a place in the coordinates of a panel."""
        column, up = self.figure.axes[panel].transData.transform((x, y))
        return self.pixels[len(self.pixels) - 1 - int(up), int(column)]


def is_close(found, colour):
    return np.abs(found - to_rgb(colour)).max(axis=-1) < 0.02


def looks(found, colour):
    """Whether a pixel has the hue of a colour, however pale."""
    hue, saturation, _ = rgb_to_hsv(found)
    return bool(abs(hue - rgb_to_hsv(to_rgb(colour))[0]) < 0.03 and saturation > 0.1)


def test_beads_are_where_they_must_be():
    """Each in the colour of its species, as large as asked; nothing elsewhere."""
    beads = particles([(5, 5), (1, 9), (9, 2)], (10, 10), [0, 1, 2])
    for size in (5, 12):
        picture = Picture(draw(beads, radius=0.8, size=size))
        for place, colour in zip(beads.position.T, (BLUE, ORANGE, GREEN)):
            assert is_close(picture.at(*place), colour)
            assert is_close(picture.at(*place + 0.5), colour)
        for empty in [(9, 9), (1, 1), (5, 6), (5.7, 5.7)]:
            assert is_close(picture.at(*empty), WHITE)
        assert picture.pixels.shape[1] == pytest.approx(size / 2.54 * 300, abs=1)
        assert set("ABC") <= set(picture.texts)


@pytest.mark.parametrize("across", [False, True])
def test_a_bond_goes_to_the_nearest_image(across):
    """Over the border of the box, not through its middle; in the colours of its ends."""
    ends = [(0.9, 5), (9.3, 5)] if across else [(3, 5), (6, 5)]
    picture = Picture(draw(particles(ends, (10, 10), [0, 1], [(0, 1)]), radius=0.2))
    middle, low, high = picture.at(4.4, 5), picture.at(0.3, 5), picture.at(9.8, 5)
    assert is_close(middle, WHITE) == across
    assert is_close(low, WHITE) != across and is_close(high, WHITE) != across
    halves = (low, high) if across else (picture.at(4.2, 5), picture.at(4.8, 5))
    assert is_close(halves[0], BLUE) and is_close(halves[1], ORANGE)


@pytest.mark.parametrize(
    ("view", "near", "far", "at"),
    [
        ("y", (7, 1, 4), (7, 9, 4), (7, 4)), ("x", (9, 7, 4), (1, 7, 4), (7, 4)),
        ("z", (7, 4, 9), (7, 4, 1), (7, 4)),
    ],
)  # fmt: skip
def test_nearer_beads_hide_others_and_are_stronger(view, near, far, at):
    """Whatever their order in the file; axes to the right and upwards are right-handed."""
    beside = np.array(far) - 3 * np.isin(list("xyz"), list("xyz".replace(view, ""))[:1])
    for order in ([0, 1, 2], [2, 1, 0]):
        place = np.array([near, far, beside])[order]
        picture = Picture(draw(particles(place, (10, 10, 10), order), view=view))
        assert looks(picture.at(*at), BLUE)
        pale = picture.at(at[0] - 3, at[1])
        assert looks(pale, GREEN) and pale.min() > 0.5


def test_a_slab_and_some_species():
    """Beads elsewhere, or of others, are not drawn, nor in the legend."""
    beads = particles([(5, 5, 1), (5, 5, 9), (2, 2, 1.5)], (10, 10, 10), [0, 1, 2])
    picture = Picture(draw(beads, slab=("z", 0, 2), species=["A", "B"]))
    assert looks(picture.at(5, 5), BLUE) and is_close(picture.at(2, 2), WHITE)
    assert {"A", "B", "0 < $z$ / $r_c$ < 2"} <= set(picture.texts) and "C" not in picture.texts


def test_colours_of_molecules():
    """One within each, others beside it; gray without bonds."""
    place = [(2, 2), (3, 2), (2, 4), (3, 4), (8, 8)]
    picture = Picture(draw(particles(place, (10, 10), bonds=[(0, 1), (2, 3)], names="A")))
    one, same, other, _, gray = (picture.at(*p) for p in place)
    assert (one == same).all() and np.abs(one - other).max() > 0.1 and np.ptp(gray) < 0.02
    with pytest.raises(UserError, match="colour 'mass': allowed are species and, where beads are"):
        draw(particles(place, (10, 10)), colour="mass")


MIXTURE = SCENE | {
    "molecules": [{"architecture": "A 2", "density": 1}, {"architecture": "B", "density": 2}],
    "repulsion": {"A A": 25, "B B": 25, "A B": 40}, "bond": {"stiffness": 20},
    "observe": ["thermo", {"trajectory": {"every": 5}}],
    "steps": {"equilibrate": 300, "sample": 30}, "box": 5,
}  # fmt: skip


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The files of a run: result and trajectory."""
    from dpd.commands.main import main

    folder = tmp_path_factory.mktemp("made")
    (folder / "scene.yaml").write_text(yaml.safe_dump(MIXTURE))
    assert main(["run", str(folder / "scene.yaml"), "-o", str(folder / "run.nc")]) == 0
    return folder


@pytest.fixture
def files(folder, made):
    """Copies of these files in a folder to work in."""
    for path in made.iterdir():
        Path(path.name).write_bytes(path.read_bytes())
    return folder


def size_of(path):
    with Image.open(path) as picture:
        return picture.size


def test_a_picture_of_a_run(files, dpd):
    """Beside the file; wider and finer if asked; the same bytes again."""
    for _ in range(2):
        assert dpd("draw", "run.nc", "--overwrite") == (0, "")
    assert abs(size_of("run.png")[0] - 8.6 / 2.54 * 300) <= 1
    arguments = "--size 12 --dpi 100 --view z --slab z -1 2 --species A"
    assert dpd("draw", "run.nc", "-o", "other.png", *arguments.split())[0] == 0
    assert abs(size_of("other.png")[0] - 12 / 2.54 * 100) <= 1


def test_a_notebook_shows_a_picture_once(files):
    """What IPython asks a figure for is an image; pyplot, which shows its own, has none of it."""
    before = pyplot.get_fignums()
    figure = draw("run.nc")
    image, about = figure._repr_png_()
    assert abs(size_of(BytesIO(image))[0] - 8.6 / 2.54 * 300) <= 1 and about == {"width": 325}
    assert figure._repr_html_() is None and pyplot.get_fignums() == before


def test_all_kinds_of_files_are_drawn_alike(files):
    """A result, its last frame, LAMMPS data, a first configuration, and the run in Python."""
    import xarray as xr

    last = read("run.nc")
    for name in ("copy.data", "copy.gsd", "copy.nc"):
        write(last, name)
    expected = Picture(draw("run.nc", dpi=100, colour="molecule")).pixels
    with xr.open_dataset("run.nc") as run:
        for source in ("copy.data", "copy.gsd", "copy.nc", "run.gsd", run):
            found = Picture(draw(source, dpi=100, colour="molecule")).pixels
            assert np.abs(found - expected).mean() < 2e-3
    other = Picture(draw("run.gsd", 0, dpi=100, colour="molecule")).pixels
    assert np.abs(other - expected).mean() > 2e-2


def test_bad_files_and_bad_names(files, dpd):
    """One sentence each, and nothing is written."""
    Path("garbage.nc").write_bytes(random.Random(1).randbytes(3000))
    os.symlink("run.nc", "link.png")
    before = {path: path.stat().st_mtime_ns for path in Path().iterdir()}
    for arguments, said in (
        (["garbage.nc"], "garbage.nc: not a whole NetCDF file"),
        (["run.gsd", "--frame", 99], "run.gsd: there is no frame 99; allowed: 0 to"),
        (["run.nc", "-o", "run.jpg"], "run.jpg: its name does not say what kind of picture"),
        (["run.nc", "--species", "A", "D"], "no species is called 'D'; allowed: A, B"),
        (["run.nc", "--slab", "z", "10", "12"], "the edges are 5, 5, 5"),
        (["run.nc", "--slice", "z=1"], "holds no density field"),
        (["run.nc", "-o", "link.png"], "link.png: what is written would take the place of what"),
    ):
        code, found = dpd("draw", *arguments)
        assert code == 1 and found.startswith("error: ") and said in found, (arguments, found)
        assert found.count("\n") == 1 and len(found) < 500
        assert {path: path.stat().st_mtime_ns for path in Path().iterdir()} == before, arguments
