"""Density fields in files: read from run.nc, and as VTK image data."""

import sys
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from dpd import files
from dpd.commands.main import main
from dpd.errors import UserError
from dpd.particles.netcdf import Fields, fields_of, read_fields, write_image
from dpd.runs.run import simulate
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start

BOXES = {2: (5.0, 6.5), 3: (5.0, 6.5, 4.0)}
SHAPES = {2: (4, 5), 3: (4, 5, 3)}


def made_up(dimension, frames=3):
    """Random densities of two species."""
    rng = np.random.default_rng(dimension)
    density = rng.random((frames, 2, *SHAPES[dimension])).astype(np.float32)
    box = np.tile(BOXES[dimension], (frames, 1))
    return Fields(("A", "Tail"), 4.0 * np.arange(frames) + 2, box, density)


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
def test_image_data_holds_the_field(dimension, tmp_path):
    """Read by the description of the format: cells with x first, extent, spacing, origin."""
    fields = made_up(dimension)
    path = tmp_path / "field.vti"
    write_image(fields, 1, path)
    assert [file.name for file in tmp_path.iterdir()] == ["field.vti"]
    about, arrays = vti(path)
    cells = (*SHAPES[dimension], 1)[:3]
    assert [int(word) for word in about["WholeExtent"].split()][1::2] == list(cells)
    spacing = [float(word) for word in about["Spacing"].split()]
    assert spacing == pytest.approx([*np.array(BOXES[dimension]) / SHAPES[dimension], 1.0][:3])
    origin = [0, 0, 0] if dimension == 3 else [0, 0, -0.5]
    assert [float(word) for word in about["Origin"].split()] == origin
    for name, expected in zip(("density A", "density Tail"), fields.density[1]):
        np.testing.assert_array_equal(arrays[name], expected.ravel(order="F"))


SCENE = {
    "dimension": 3, "box": [4.0, 5.0, 6.0], "repulsion": {"A A": 25, "A B": 40, "B B": 25},
    "molecules": [{"architecture": "A", "count": 200}, {"architecture": "B", "count": 160}],
    "integrator": {"scheme": "gw-vv", "dt": 0.04}, "steps": {"sample": 40},
    "observe": [{"density_field": {"every": 2, "average": 8, "spacing": 1}}],
}  # fmt: skip


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run.nc with three frames of a field."""
    path = tmp_path_factory.mktemp("run") / "run.nc"
    scene = Scene(SCENE)
    simulate(scene, path, make_start(scene))
    return path


def test_the_field_of_a_run_is_converted(run, tmp_path, capsys):
    """From the command line; every bead is in it."""
    path = tmp_path / "field.vti"
    assert main(["convert", str(run), str(path), "--frame", "1"]) == 0
    assert "frame 1 of densities of A, B in 4 x 5 x 6 cells, 3 frames, at t = 1" in (
        capsys.readouterr().out
    )
    _, arrays = vti(path)
    assert arrays["density A"].sum() == pytest.approx(200, rel=1e-5)
    fields = read_fields(run)
    np.testing.assert_array_equal(arrays["density B"], fields.density[1, 1].ravel(order="F"))


def test_frames_of_a_lost_run(run):
    """Those that it has."""
    variables, _ = files.read(run)
    variables["density_field"][2] = np.nan
    assert len(fields_of(variables, "run.nc").time) == 2
    variables["density_field"][:] = np.nan
    with pytest.raises(UserError, match=r"run\.nc: the run was lost before the first frame"):
        fields_of(variables, "run.nc")
    variables["field_time"] = np.zeros(7)
    with pytest.raises(UserError, match=r"run\.nc: its density field is damaged"):
        fields_of(variables, "run.nc")


def test_what_is_no_field(run, tmp_path, capsys):
    """One sentence each, and no file."""
    other = tmp_path / "other.nc"
    files.write(other, {"kT": (("sample",), np.ones(3), "kT", "kT")}, {})
    cases = {
        other: ([], "holds no density field"),
        run: (["--frame", "3"], "no frame 3 of the density field; allowed: 0 to 2"),
    }
    for source, (options, said) in cases.items():
        assert main(["convert", str(source), str(tmp_path / "x.vti"), *options]) == 1
        assert said in capsys.readouterr().err
    assert not (tmp_path / "x.vti").exists()
    assert main(["convert", str(run), str(tmp_path / "x.vtk")]) == 1
    assert "allowed: .gsd, .data, .lmp, .nc, .vti" in capsys.readouterr().err


def test_a_library_that_is_missing(run, tmp_path, capsys, monkeypatch):
    """The extra that brings it."""
    monkeypatch.setitem(sys.modules, "pyevtk.hl", None)
    assert main(["convert", str(run), str(tmp_path / "x.vti")]) == 1
    assert "pip install 'dpd-papers[draw]'" in capsys.readouterr().err
    assert not (tmp_path / "x.vti").exists()
