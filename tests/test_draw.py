"""Pictures of beads and bonds: what is where in them, and what is refused."""

import os
import random
import re
import stat
from io import BytesIO
from itertools import pairwise
from pathlib import Path

import gsd.hoomd
import matplotlib as mpl
import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib import pyplot
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import rgb_to_hsv, to_rgb
from PIL import Image

from dpd import draw
from dpd.errors import UserError
from dpd.particles.formats import read, write
from dpd.particles.particles import Particles
from dpd.report.colours import BLUE, GREEN, ORANGE
from dpd.report.pictures.colouring import molecule_colours
from dpd.report.pictures.shapes import pieces_of, usual_radius
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
        self.axes = figure.axes[0]
        self.texts = [text.get_text() for text in figure.findobj(lambda a: hasattr(a, "get_text"))]

    def at(self, x, y):
        """The colour at a place in the coordinates of the axes."""
        column, up = self.axes.transData.transform((x, y))
        return self.pixels[len(self.pixels) - 1 - int(up), int(column)]

    def count(self, colour):
        """Number of pixels of a colour."""
        return int(is_close(self.pixels, colour).sum())

    def middle(self, colour):
        """Mean row and column of the pixels of a colour, as shares of the picture."""
        return np.argwhere(is_close(self.pixels, colour)).mean(axis=0) / self.pixels.shape[:2]


def is_close(found, colour):
    return np.abs(found - to_rgb(colour)).max(axis=-1) < 0.02


def looks(found, colour):
    """Whether a pixel has the hue of a colour, however pale or dark: spheres shine and fade."""
    hue, saturation, _ = rgb_to_hsv(found)
    return bool(abs(hue - rgb_to_hsv(to_rgb(colour))[0]) < 0.03 and saturation > 0.1)


# Beads in two dimensions.


def test_beads_are_where_they_must_be():
    """Each in the colour of its species; nothing elsewhere."""
    beads = particles([(5, 5), (1, 9), (9, 2)], (10, 10), [0, 1, 2])
    picture = Picture(draw(beads))
    for place, colour in zip(beads.position.T, (BLUE, ORANGE, GREEN)):
        assert is_close(picture.at(*place), colour)
    for empty in [(9, 9), (1, 1), (5, 6), (5, 4)]:
        assert is_close(picture.at(*empty), WHITE)
    row, column = picture.middle(ORANGE)
    assert row < 0.3 and column < 0.3  # the legend is above the picture, and in its middle


def test_beads_are_as_large_as_asked():
    """A radius in r_c, whatever the size of the picture."""
    for size in (5, 12):
        picture = Picture(draw(particles([(5, 5)], (10, 10), names="A"), radius=2, size=size))
        assert is_close(picture.at(6.5, 5), BLUE) and is_close(picture.at(5, 3.5), BLUE)
        assert is_close(picture.at(7.2, 5), WHITE) and is_close(picture.at(6.6, 6.6), WHITE)
        assert picture.pixels.shape[1] == pytest.approx(size / 2.54 * 300, abs=1)


def test_a_bond_has_the_colours_of_its_ends():
    """Half and half."""
    picture = Picture(draw(particles([(3, 5), (6, 5)], (10, 10), [0, 1], [(0, 1)])))
    assert is_close(picture.at(4.2, 5), BLUE) and is_close(picture.at(4.8, 5), ORANGE)
    alone = Picture(draw(particles([(3, 5), (6, 5)], (10, 10), [0, 1])))
    assert is_close(alone.at(4.2, 5), WHITE)


@pytest.mark.parametrize("across", [False, True])
def test_a_bond_goes_to_the_nearest_image(across):
    """Over the border of the box, not through its middle."""
    ends = [(0.9, 5), (9.3, 5)] if across else [(3, 5), (6, 5)]
    picture = Picture(draw(particles(ends, (10, 10), [0, 1], [(0, 1)]), radius=0.2))
    assert is_close(picture.at(5, 6), WHITE)
    middle, low, high = picture.at(4.4, 5), picture.at(0.3, 5), picture.at(9.8, 5)
    assert is_close(middle, WHITE) == across
    assert is_close(low, WHITE) != across and is_close(high, WHITE) != across
    if across:  # its middle is at 0.1
        assert is_close(low, BLUE) and is_close(high, ORANGE)


boxes = st.lists(st.floats(1, 20), min_size=2, max_size=3)


@settings(max_examples=60, deadline=None)
@given(boxes, st.integers(2, 8), st.integers(0, 2**32 - 1), st.sampled_from([0.0, 0.1]))
def test_pieces_of_bonds(box, beads, seed, hidden):
    """All in the box; together as long as the bonds; they touch the beads that they belong to."""
    place = np.random.default_rng(seed).uniform(0, 1, (beads, len(box))) * box
    chain = particles(place, tuple(box), bonds=list(pairwise(range(beads))))
    pieces = pieces_of(chain, np.ones(beads, bool), hidden)
    edges = np.array(box)[:, None]
    for end in (pieces.first, pieces.last):
        assert (end >= -1e-9 * edges).all() and (end <= (1 + 1e-9) * edges).all()
    apart = np.diff(place, axis=0)
    apart -= box * np.round(apart / box)
    length = np.linalg.norm(apart, axis=1)
    found = np.linalg.norm(pieces.last - pieces.first, axis=0).sum()
    assert found == pytest.approx(np.maximum(length - 2 * hidden, 0).sum(), abs=1e-6)
    assert (np.linalg.norm(pieces.last - pieces.first, axis=0) <= length.max() / 2 + 1e-9).all()


# Three dimensions.


def test_nearer_beads_hide_others():
    """Of two on a line of sight, whatever their order in the file."""
    for order in ([0, 1], [1, 0]):
        place = np.array([(5, 1, 5), (5, 9, 5)])[order]
        beads = particles(place, (10, 10, 10), order)  # blue is the one at low y
        front, back = Picture(draw(beads, view=(0, 0))), Picture(draw(beads, view=(180, 0)))
        assert looks(front.at(0, 0), BLUE) and looks(back.at(0, 0), ORANGE)


def test_nearer_beads_are_larger_and_stronger():
    """And farther ones are paler, on black as on white."""
    beads = particles([(2, 1, 5), (8, 9, 5)], (10, 10, 10), names="A")
    for dark in (False, True):
        picture = Picture(draw(beads, view=(0, 0), dark=dark))
        paper = picture.pixels[0, 0]
        assert is_close(paper, "black" if dark else WHITE)
        near, far = picture.at(-3.6, 0), picture.at(2.6, 0)
        assert np.abs(near - paper).sum() > 1.3 * np.abs(far - paper).sum() > 0.1
        left, right = np.array_split(np.abs(picture.pixels - paper).sum(axis=2) > 0.1, 2, axis=1)
        middle = len(left) // 2
        assert left[middle - 20 : middle].sum() > right[middle - 20 : middle].sum()


@pytest.mark.parametrize(
    ("view", "place"),
    [
        ((0, 0), (5, 9, 9)), ((90, 0), (9, 5, 9)), ((0, 90), (5, 9, 5)), ((180, 0), (5, 5, 9)),
    ],
)  # fmt: skip
def test_directions_of_view(view, place):
    """z is upwards; from above, y is."""
    picture = Picture(draw(particles([place], (10, 10, 10), names="A"), view=view))
    lit = np.argwhere(np.ptp(picture.pixels, axis=2) > 0.2).mean(axis=0) / picture.pixels.shape[:2]
    assert lit[0] < 0.35 and lit[1] == pytest.approx(0.5, abs=0.06)


def test_right_and_left():
    """From low y, x is to the right; from high x, y is."""
    for view, place in (((0, 0), (9, 5, 5)), ((90, 0), (5, 9, 5)), ((0, 90), (9, 5, 5))):
        picture = Picture(draw(particles([place], (10, 10, 10), names="A"), view=view))
        lit = np.argwhere(np.ptp(picture.pixels, axis=2) > 0.2).mean(axis=0)
        assert lit[1] / picture.pixels.shape[1] > 0.65


def test_a_bond_behind_a_bead_is_hidden():
    """And one before it is seen."""
    place = [(4, 5, 5), (9, 5, 5), (6.5, 1, 5), (6.5, 9, 5)]
    beads = particles(place, (13, 10, 10), [1, 1, 0, 2], [(0, 1)])
    before, behind = Picture(draw(beads, view=(0, 0))), Picture(draw(beads, view=(180, 0)))
    assert looks(before.at(0, 0), BLUE) and looks(behind.at(0, 0), GREEN)
    alone = Picture(draw(beads, view=(0, 0), species=["B"]))
    assert looks(alone.at(0, 0), ORANGE)
    beyond = Picture(draw(beads, slab=("y", 4, 6)))
    assert looks(beyond.at(0, 0), ORANGE)


def test_a_slab_and_some_species():
    """Beads elsewhere, or of others, are not drawn, nor in the legend."""
    beads = particles([(5, 5, 1), (5, 5, 9), (2, 2, 1.5)], (10, 10, 10), [0, 1, 2])
    picture = Picture(draw(beads, slab=("z", 0, 2), caption=True, species=["A", "B"]))
    assert looks(picture.at(0, 0), BLUE)
    assert is_close(picture.at(-3, -3), WHITE)
    assert "1 of 3 beads, density 0.003 $r_c^{-3}$, step 0" in picture.texts
    assert {"A", "B"} <= set(picture.texts) and "C" not in picture.texts


def test_names_that_mean_something_to_the_library():
    """Formulas, and names that a legend would leave out."""
    names = ("$\\frac$", "_hidden", "x" * 60)
    picture = Picture(draw(particles([(1, 1), (2, 2)], (4, 4), [0, 1], names=names)))
    assert set(names[:2]) <= set(picture.texts) and "x" * 15 + "..." in picture.texts


# Molecules.


def test_neighbouring_molecules_differ():
    """Lines of beads side by side; the same colour within each; gray without bonds."""
    columns, length = 17, 10
    order = [15 * number % columns for number in range(columns)]  # 8 apart in it are neighbours
    place = [(0.5 + x, 0.5 + y) for x in order for y in range(length)]
    bonds = [
        (x * length + y, x * length + y + 1) for x in range(columns) for y in range(length - 1)
    ]
    chains = particles([*place, (8, 14.7)], (17, 20), bonds=bonds, names="A")
    found = molecule_colours(chains)
    kinds = found.kind[:-1].reshape(columns, length)
    assert (kinds == kinds[:, :1]).all()
    in_space = kinds[np.argsort(order), 0]
    assert (in_space != np.roll(in_space, 1)).all()
    assert found.kind[-1] not in kinds
    picture = Picture(draw(chains))
    assert all(is_close(picture.at(*p), found.palette[k]) for p, k in zip(place, found.kind))
    by_species = Picture(draw(chains, colour="species"))
    assert all(is_close(by_species.at(*p), BLUE) for p in place)


def test_looks_of_other_figures_do_not_matter(recwarn):
    """What figures of papers, or a notebook, have set for theirs."""
    beads = particles([(5, 5, 1), (2, 2, 9)], (10, 10, 10), [0, 1])
    expected = Picture(draw(beads, caption=True)).pixels
    others = {"figure.constrained_layout.use": True, "font.size": 20, "lines.markersize": 9}
    with mpl.rc_context(others):
        assert np.array_equal(Picture(draw(beads, caption=True)).pixels, expected)
    assert not recwarn.list


# Choices that are refused.


@pytest.mark.parametrize(
    ("choices", "said"),
    [
        ({"colour": "mass"}, "colour: 'mass' is unknown; allowed: species, molecule"),
        ({"colour": "molecule"}, "no beads are bonded"),
        ({"species": ("A", "D")}, "no species is called 'D'; allowed: A, B, C"),
        ({"slab": ("w", 0, 1)}, "is no slice of a box"),
        ({"slab": ("xy", 0, 1)}, "is no slice of a box"),
        ({"slab": ("z", 2, 1)}, "is no slice of a box"),
        ({"slab": ("z", 0, float("nan"))}, "is no slice of a box"),
        ({"slab": 3}, "is no slice of a box"),
        ({"slab": ("z", 10, 12)}, "which goes from 0 to 10 along z"),
        ({"view": (0, 91)}, "is no direction"),
        ({"view": ("north", 0)}, "is no direction"),
        ({"size": 0}, "size: 0 is out of range; allowed: 2 to 100"),
        ({"size": 100, "dpi": 2400}, "wider than 10000 pixels"),
        ({"dpi": float("nan")}, "dpi: nan is out of range"),
        ({"radius": -1}, "radius: -1 is out of range"),
        ({"sice": 1}, "there is no choice 'sice'"),
    ],
)
def test_choices_that_are_refused(choices, said):
    """In a sentence that says what is allowed."""
    beads = particles([(5, 5, 1)], (10, 10, 10))
    with pytest.raises(UserError, match=re.escape(said)):
        draw(beads, **choices)


def test_two_dimensions_have_no_third():
    """No view, and no slab along z."""
    beads = particles([(5, 5)], (10, 10))
    with pytest.raises(UserError, match="seen from one side only"):
        draw(beads, view=(0, 0))
    with pytest.raises(UserError, match="no axis 'z' to cut a slab along; allowed: x, y"):
        draw(beads, slab=("z", 0, 1))


def test_particles_are_checked():
    """As those of a file are."""
    with pytest.raises(UserError, match="the particles: bead 0 has a position that is not"):
        draw(particles([(5, float("nan"))], (10, 10)))
    with pytest.raises(UserError, match="the particles: bond 0 has bead 7"):
        draw(particles([(5, 5)], (10, 10), bonds=[(0, 7)]))


# Files.

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
    """Beside the file; the same bytes again; wider and finer if asked."""
    assert dpd("draw", "run.nc") == (0, "")
    first = Path("run.png").read_bytes()
    width, _ = size_of("run.png")
    assert abs(width - 8.6 / 2.54 * 300) <= 1
    assert dpd("draw", "run.nc", "-o", "other.png") == (0, "")
    assert Path("other.png").read_bytes() == first
    arguments = "--size 12 --dpi 100 --caption --dark --view -30 20 --slab z -1 2 --species A"
    assert dpd("draw", "run.nc", "-o", "other.png", *arguments.split())[0] == 0
    assert abs(size_of("other.png")[0] - 12 / 2.54 * 100) <= 1


def test_a_notebook_shows_a_picture_once(files):
    """What IPython asks a figure for is an image; pyplot, which shows its own, has none of it."""
    figure = draw("run.nc")
    image, about = figure._repr_png_()
    assert abs(size_of(BytesIO(image))[0] - 8.6 / 2.54 * 300) <= 1 and about == {"width": 325}
    assert figure._repr_html_() is None and not pyplot.get_fignums()


@pytest.mark.parametrize("suffix", [".pdf", ".svg"])
def test_drawings_with_lines(files, dpd, suffix):
    """The same bytes again, as no date is in them."""
    for name in ("one", "other"):
        assert dpd("draw", "run.nc", "-o", f"{name}{suffix}", "--colour", "molecule") == (0, "")
    assert Path(f"one{suffix}").read_bytes() == Path(f"other{suffix}").read_bytes()
    assert Path(f"one{suffix}").read_bytes()[:5] in (b"%PDF-", b"<?xml")


def test_all_kinds_of_files_are_drawn_alike(files, dpd):
    """A result, its last frame, LAMMPS data, a first configuration, and the run in Python."""
    import xarray as xr

    last = read("run.nc")
    write(last, "copy.data")
    write(last, "copy.gsd")
    write(last, "copy.nc")
    expected = Picture(draw("run.nc", dpi=100, colour="molecule")).pixels
    with xr.open_dataset("run.nc") as run:
        sources = ["copy.data", "copy.gsd", "copy.nc", "run.gsd", run]
        for source in sources:
            found = Picture(draw(source, dpi=100, colour="molecule")).pixels
            assert difference(found, expected) < 2e-3
    other = Picture(draw("run.gsd", 0, dpi=100, colour="molecule")).pixels
    assert difference(other, expected) > 2e-2


def difference(one, other):
    """Mean difference of two pictures; their sizes may differ by a pixel, as files round."""
    sizes = np.array([one.shape, other.shape])
    assert np.ptp(sizes, axis=0).max() <= 1
    high, wide, _ = sizes.min(axis=0)
    return np.abs(one[:high, :wide] - other[:high, :wide]).mean()


def test_the_configuration_of_older_results(folder, dpd):
    """What the observable of that name saw last; without it, a sentence says what to do."""
    import netCDF4

    Path("scene.yaml").write_text(yaml.safe_dump(SCENE | {"observe": ["thermo", "configuration"]}))
    assert dpd("run", "scene.yaml", "-o", "run.nc")[0] == 0
    expected = Picture(draw("run.nc", dpi=60)).pixels
    with netCDF4.Dataset("run.nc", "a") as file:
        file.renameVariable("last_position", "gone")
    assert np.array_equal(Picture(draw("run.nc", dpi=60)).pixels, expected)
    with netCDF4.Dataset("run.nc", "a") as file:
        file.renameVariable("position", "gone_too")
    code, said = dpd("draw", "run.nc")
    assert code == 1 and said.startswith("error: run.nc: holds no last configuration. `dpd run`")


def test_bad_files_and_bad_names(files, dpd):
    """One sentence each, and nothing is written."""
    Path("garbage.nc").write_bytes(random.Random(1).randbytes(3000))
    Path("garbage.gsd").write_bytes(random.Random(2).randbytes(3000))
    Path("text.data").write_text("hello\n\nworld\n")
    Path("scene.txt").write_text("box: 4\n")
    Path("folder.nc").mkdir()
    os.symlink("run.nc", "link.png")
    before = {path: path.stat().st_mtime_ns for path in Path().iterdir()}
    for arguments, said in (
        (["garbage.nc"], "garbage.nc: not a whole NetCDF file"),
        (["garbage.gsd"], "garbage.gsd: not a whole GSD file"),
        (["text.data"], "text.data: "),
        (["scene.txt"], "scene.txt: a suffix '.txt', which says what kind of file it is; allowed"),
        (["missing.nc"], "missing.nc: there is no such file"),
        (["folder.nc"], "folder.nc: is not a file"),
        (["run.gsd", "--frame", 99], "run.gsd: there is no frame 99; allowed: 0 to"),
        (["run.nc", "--frame", 3], "run.nc: there is no frame 3"),
        (["run.nc", "-o", "run.jpg"], "run.jpg: its name does not say what kind of picture"),
        (["run.nc", "-o", "run"], "run: its name does not say what kind of picture"),
        (["run.nc", "-o", "run.nc"], "run.nc: its name does not say what kind of picture"),
        (["run.nc", "-o", "link.png"], "link.png: what is written would take the place of run.nc"),
        (["run.nc", "-o", "folder.nc/x/y.png", "--slab", "z", 9, 10], "run.nc: the slab from 9 to"),
        (["run.nc", "-o", "a.png", "--view", "up", 0], "view: ['up', '0'] is no direction"),
        (["run.nc", "--movie", "run.gif"], "run.nc: a movie is made of a trajectory (.gsd)"),
        (["run.gsd", "--movie", "run.avi"], "run.avi: its name does not say what kind of movie"),
        (["run.gsd", "--movie", "run.gsd"], "run.gsd: its name does not say what kind of movie"),
        (["run.gsd", "--movie", "a.gif", "-o", "a.png"], "-o and --movie: "),
        (["run.gsd", "--movie", "a.gif", "--rate", 0], "rate: 0 is out of range"),
        (["run.gsd", "--movie", "a.gif", "--rate", "nan"], "rate: nan is out of range"),
    ):
        code, found = dpd("draw", *arguments)
        assert code == 1 and found.startswith(f"error: {said}"), (arguments, found)
        assert found.count("\n") == 1 and len(found) < 500
        assert {path: path.stat().st_mtime_ns for path in Path().iterdir()} == before, arguments


@pytest.mark.parametrize("name", ["run.nc", "run.gsd"])
def test_files_that_were_cut_off(files, dpd, name):
    """At many places: refused, or an earlier frame; never half a picture."""
    whole = Path(name).read_bytes()
    refused = 0
    for share in (0, 0.001, 0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99):
        Path(f"cut-{name}").write_bytes(whole[: int(share * len(whole))])
        code, said = dpd("draw", f"cut-{name}", "-o", "cut.png", "--dpi", 50)
        assert (code, said.count("\n")) in ((0, 0), (1, 1)), said
        assert Path("cut.png").exists() == (code == 0)
        Path("cut.png").unlink(missing_ok=True)
        refused += code
    assert refused > 5


def test_a_place_that_cannot_be_written(files, dpd):
    """A file where a folder should be; and no draft is left."""
    Path("file").write_text("")
    code, said = dpd("draw", "run.nc", "-o", "file/run.png")
    assert code == 1 and said.startswith("error: file/run.png: cannot be")
    assert not list(files.rglob("*.writing"))


# Movies.


def test_a_movie(files, dpd):
    """As many frames as asked, at the speed asked; they differ."""
    frames = len(gsd.hoomd.open("run.gsd"))
    assert dpd("draw", "run.gsd", "--movie", "run.gif", "--size", 5, "--rate", 10)[0] == 0
    with Image.open("run.gif") as movie:
        assert movie.n_frames == frames > 2 and movie.info["duration"] == 100
        assert abs(movie.size[0] - 5 / 2.54 * 150) <= 1
        pixels = []
        for frame in range(frames):
            movie.seek(frame)
            pixels.append(np.asarray(movie.convert("RGB"), float))
    assert all(np.abs(one - other).mean() > 2 for one, other in pairwise(pixels))
    radius = usual_radius(read("run.gsd", 0))  # it stays through the movie
    figure = draw("run.gsd", frame=frames - 1, size=5, dpi=150, radius=radius)
    last = Picture(figure).pixels * 255
    assert np.abs(pixels[-1] - last).mean() < 6 < np.abs(pixels[0] - last).mean()
    assert dpd("draw", "run.gsd", "--movie", "run.gif", "--every", 2, "--dpi", 50)[0] == 0
    with Image.open("run.gif") as movie:
        assert movie.n_frames == -(-frames // 2)


def test_a_movie_of_other_beads(files, dpd):
    """A trajectory in which a box changes, or which is cut off: refused, and nothing is left."""
    with gsd.hoomd.open("run.gsd") as source, gsd.hoomd.open("other.gsd", "w") as other:
        for number, frame in enumerate(source):
            frame.configuration.box = [5 + number % 2, 5, 5, 0, 0, 0]
            other.append(frame)
    Path("empty.gsd").write_bytes(b"")
    gsd.hoomd.open("none.gsd", "w").close()
    before = set(Path().iterdir())
    for name, said in (
        ("other.gsd", "other.gsd: frame 1 has other beads, bonds or edges of the box"),
        ("empty.gsd", "empty.gsd: not a whole GSD file"),
        ("none.gsd", "none.gsd: has no frames"),
        ("missing.gsd", "missing.gsd: "),
    ):
        code, found = dpd("draw", name, "--movie", "a.gif", "--dpi", 40)
        assert code == 1 and found.startswith(f"error: {said}") and found.count("\n") == 1, found
        assert set(Path().iterdir()) == before


def program(folder, text):
    """A program called ffmpeg, alone on the path."""
    (folder / "bin").mkdir(exist_ok=True)
    path = folder / "bin" / "ffmpeg"
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return str(folder / "bin")


def test_mp4_needs_a_program(files, dpd, monkeypatch):
    """Without it a sentence says so; with it the program gets all frames."""
    frames = len(gsd.hoomd.open("run.gsd"))
    monkeypatch.setenv("PATH", str(files / "bin"))
    code, said = dpd("draw", "run.gsd", "--movie", "run.mp4")
    assert code == 1 and said.startswith("error: run.mp4: the program ffmpeg, which writes mp4, is")
    program(files, 'for last; do :; done; /bin/cat > "$last"')
    assert dpd("draw", "run.gsd", "--movie", "run.mp4", "--size", 4, "--dpi", 50)[0] == 0
    assert Path("run.mp4").stat().st_size % (4 * frames) == 0  # what it got: four bytes a pixel
    Path("run.mp4").unlink()
    program(files, "echo no such codec >&2; exit 1")
    code, said = dpd("draw", "run.gsd", "--movie", "run.mp4", "--size", 4, "--dpi", 50)
    assert code == 1
    assert said.endswith("error: run.mp4: ffmpeg could not write the movie: no such codec\n")
    assert not list(files.glob("*.mp4*"))
