"""Density fields: as VTK image data, and what is where in their pictures."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest
import xarray as xr

import dpd
from dpd.commands.main import main
from dpd.errors import UserError
from dpd.report.draw_fields import smoothed
from paper_figures.cerius2_1998.shared import points_along, triangles_around
from tests.test_draw import Picture

BOX = np.array([6.0, 8.0, 10.0])
CELLS = (24, 32, 40)


def middles(box=BOX, cells=CELLS):
    """Coordinates of the middles of cells, an array for each axis, to be broadcast."""
    axes = [(np.arange(n) + 0.5) * edge / n for n, edge in zip(cells, box)]
    return np.meshgrid(*axes, indexing="ij", sparse=True)


def ball(centre, radius, box=BOX, cells=CELLS):
    """A density that falls from 2 to 0 at a distance from a point, over images."""
    square = 0
    for along, at, edge in zip(middles(box, cells), centre, box):
        apart = along - at
        square = square + (apart - edge * np.round(apart / edge)) ** 2
    return 1 + np.tanh(2 * (radius - np.sqrt(square)))


def run_of(*frames, box=BOX, names="AB"):
    """A run's dataset with these densities, (species, ...) each."""
    axes = [f"field_{axis}" for axis in "xyz"[: len(box)]]
    return xr.Dataset({
        "density_field": (("frame", "species", *axes), np.array(frames, np.float32)),
        "field_time": ("frame", 2.5 + 10 * np.arange(len(frames))),
        "field_box": (("frame", "axis"), np.tile(box, (len(frames), 1))),
        "species": ("species", list(names)),
    })  # fmt: skip


def kept(run, path):
    """The same in a file."""
    run.to_netcdf(path)
    return path


def vti(path):
    """What the description of VTK's XML formats says is in a file: attributes, and arrays.

    Raw data behind an underscore, each array after its size in bytes.
    """
    content = path.read_bytes()
    begin = content.index(b"_", content.index(b"<AppendedData")) + 1
    root = ET.fromstring(content[: content.index(b"<AppendedData")] + b"</VTKFile>")
    assert root.get("type") == "ImageData" and root.get("byte_order") == "LittleEndian"
    sizes = {"UInt64": np.dtype("<u8"), "UInt32": np.dtype("<u4")}[
        root.get("header_type", "UInt32")
    ]
    kinds = {"Float32": "<f4", "Float64": "<f8"}
    arrays = {}
    for data in root.iter("DataArray"):
        at = begin + int(data.get("offset"))
        size = int(np.frombuffer(content, sizes, 1, at)[0])
        kind = np.dtype(kinds[data.get("type")])
        found = np.frombuffer(content, kind, size // kind.itemsize, at + sizes.itemsize)
        arrays[data.get("Name")] = found
    return root.find("ImageData").attrib, arrays


@pytest.mark.parametrize("dimension", [2, 3])
def test_image_data_holds_the_field(dimension, tmp_path, capsys):
    """Read by the description of the format: cells with x first, extent, spacing, origin."""
    box, cells = np.array([5.0, 6.5, 4.0])[:dimension], (4, 5, 3)[:dimension]
    density = np.random.default_rng(dimension).random((3, 2, *cells)).astype(np.float32)
    source, path = kept(run_of(*density, box=box), tmp_path / "run.nc"), tmp_path / "field.vti"
    assert main(["convert", str(source), str(path), "--frame", "1"]) == 0
    assert "frame 1 of densities of A, B in 4 x 5" in capsys.readouterr().out
    about, arrays = vti(path)
    assert [int(word) for word in about["WholeExtent"].split()][1::2] == [*cells, 1][:3]
    spacing = [float(word) for word in about["Spacing"].split()]
    assert spacing == pytest.approx([*box / cells, 1.0][:3])
    origin = [0, 0, 0] if dimension == 3 else [0, 0, -0.5]
    assert [float(word) for word in about["Origin"].split()] == origin
    for name, expected in zip(("density A", "density B"), density[1]):
        np.testing.assert_array_equal(arrays[name], expected.ravel(order="F"))
    assert main(["convert", str(source), str(tmp_path / "x.vti"), "--frame", "3"]) == 1
    assert "no frame 3; allowed: 0 to 2" in capsys.readouterr().err
    assert not (tmp_path / "x.vti").exists()


def brightness(pixel):
    """Of the colour map: its green rises with the density."""
    return pixel[1]


def test_smoothing_is_a_mean_with_gaussian_weights():
    """A constant stays, a wave shrinks as a Gaussian makes it, also at the faces."""
    x, _, _ = middles()
    wave = 1 + 0.5 * np.cos(2 * np.pi * x / 6) + 0 * ball((1, 1, 1), 1)
    places = [np.array([0.0, 1.3, 5.99, 6.0]), np.array([0.0, 4.0]), np.array([7.7])]
    found = smoothed(wave, BOX, places, 0.6)
    assert found.shape == (4, 2, 1)
    shrunk = 0.5 * np.exp(-0.5 * (2 * np.pi / 6 * 0.6) ** 2)
    expected = 1 + shrunk * np.cos(2 * np.pi * places[0] / 6)
    np.testing.assert_allclose(found, np.broadcast_to(expected[:, None, None], (4, 2, 1)), 1e-4)


@pytest.mark.parametrize("centre", [(3, 4, 5), (0, 8, 10), (5.5, 0.5, 3)])
def test_a_ball_is_a_closed_body(centre):
    """Of its volume (the theorem of Gauss), also where faces of the box cut it; the sum of areas
    is 0."""
    field = smoothed(ball(centre, 2.0), BOX, points_along(BOX), 0.1)
    corners = triangles_around(field, 1.0, BOX)
    one, two, three = corners.swapaxes(0, 1)
    across = 0.5 * np.cross(two - one, three - one)
    assert (one * across).sum() / 3 == pytest.approx(4 / 3 * np.pi * 2**3, rel=0.02)
    assert np.abs(across.sum(axis=0)).max() < 1e-3
    assert corners.min() >= 0 and (corners.max(axis=(0, 1)) <= BOX).all()
    assert not len(triangles_around(field, 2.5, BOX))


@pytest.mark.parametrize(
    ("plane", "inside", "outside"),
    [("z=9", (1, 6), (4, 2)), ("y=6.2", (1, 9), (4, 4)), ("x=0.9", (6, 9), (2, 4))],
)
def test_slices_show_what_is_in_a_plane(plane, inside, outside):
    """Bright where a ball at (1, 6, 9) is; nothing half a box away."""
    run = run_of([ball((1, 6, 9), 1.5), ball((1, 6, 9), 0.2)])
    picture = Picture(dpd.draw(run, slice=plane, species="A"))
    assert brightness(picture.at(*inside)) > 0.75 and brightness(picture.at(*outside)) < 0.1
    axis, place = plane.split("=")
    far = (float(place) + BOX["xyz".index(axis)] / 2) % BOX["xyz".index(axis)]
    away = Picture(dpd.draw(run, slice=f"{axis}={far}", species="A"))
    bar = away.figure.axes[-1]
    assert bar.get_ylim()[1] < 0.05
    names = [f"${one}$ / $r_c$" for one in "xyz" if one != axis]
    assert set(names) <= set(picture.texts) and "density of A / $r_c^{-3}$" in picture.texts


def test_times_stand_side_by_side():
    """A column for each, a row for each species, with one scale of colours in a row."""
    weak, strong = 0.5 * ball((3, 4, 5), 2), ball((3, 4, 5), 2)
    run = run_of([weak, strong], [strong, weak], [strong, strong])
    picture = Picture(dpd.draw(run, [0, -2], slice="z=5"))
    panels = [axes for axes in picture.figure.axes if axes.get_images()]
    assert len(panels) == 4
    assert [axes.get_title() for axes in panels[:2]] == [r"$t$ = 2.5 $\tau$", r"$t$ = 12.5 $\tau$"]
    at = {k: brightness(picture.at(3, 4, k)) for k in range(4)}
    assert at[0] < at[1] - 0.2 and at[3] < at[2] - 0.2
    assert picture.figure.get_figwidth() == pytest.approx(17.8 / 2.54)


def test_a_field_of_two_dimensions_is_one_plane():
    """z=0, and no other."""
    box, cells = BOX[:2], CELLS[:2]
    run = run_of([ball((2, 6), 1, box, cells)] * 2, box=box)
    picture = Picture(dpd.draw(run, slice="z=0", species=["B"]))
    assert brightness(picture.at(2, 6)) > 0.75 and brightness(picture.at(5, 2)) < 0.1
    for plane in ("z=1", "x=0"):
        with pytest.raises(UserError, match=r"no plane in the box; allowed: z=0"):
            dpd.draw(run, slice=plane)


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """A file with three frames."""
    frames = [[ball((3, 4, 5), r), ball((0, 0, 0), r)] for r in (1.0, 1.5, 2.0)]
    return kept(run_of(*frames), tmp_path_factory.mktemp("fields") / "run.nc")


REFUSED = {
    "slice w=3: is no plane in the box": "--slice w=3",
    "slice z=a: is no plane in the box; allowed: x=0 to 6": "--slice z=a",
    "no frame 3": "--slice z=1 --frame 0 3",
    "a picture of beads shows one": "--frame 0 1",
}


def test_pictures_that_are_refused(path, tmp_path, capsys, monkeypatch):
    """One sentence, and no picture."""
    monkeypatch.chdir(tmp_path)
    for said, options in REFUSED.items():
        assert main(["draw", str(path), "-o", "picture.png", *options.split()]) == 1
        assert said in capsys.readouterr().err
        assert list(tmp_path.iterdir()) == []


def test_a_picture_has_the_same_bytes_each_time(path, tmp_path):
    """As git and Snakemake want it."""
    made = [tmp_path / f"{name}.{suffix}" for name in "ab" for suffix in ("pdf", "svg")]
    for each in made:
        assert main(["draw", str(path), "--slice", "z=1", "-o", str(each), "--dpi", "50"]) == 0
    assert [made[k].read_bytes() == made[k + 2].read_bytes() for k in (0, 1)] == [True, True]
