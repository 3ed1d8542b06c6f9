"""Runs of a sweep on its axes, made up in memory."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from dpd.analysis import collect as module
from dpd.analysis.collect import RECORDED, collect
from dpd.pipeline.sweep import Axis

UNITS = {"units": "1", "long_name": "something"}


def run(width, density):
    """A run with a profile in slices of its own width."""
    z = width * (np.arange(6) + 0.5)
    species = np.array(["A", "B"])
    sample = np.linspace(0.9, 1.1, 40)
    data = xr.Dataset(
        {
            "kT": ("sample", sample, UNITS),
            "momentum": (("sample", "axis"), np.zeros((40, 3)), UNITS),
            "density_profile": (
                ("block", "species", "z"), np.full((5, 2, 6), float(density)), UNITS,
            ),
        },
        {
            "time": ("sample", 0.1 * np.arange(1, 41), UNITS),
            "z": ("z", z, {"units": "r_c", "long_name": "position"}),
            "species": ("species", species, UNITS),
        },
    )  # fmt: skip
    data.attrs = dict.fromkeys(RECORDED, 1.0) | {
        "scene": "{}", "sources": "none", "numpy": "2", "numba": "0",
    }  # fmt: skip
    return data


def collected(monkeypatch, *runs):
    """A sweep of those runs over an axis and one replica."""
    place = iter(runs)
    monkeypatch.setattr(module, "_read", lambda path, *_: next(place))
    axes = (
        Axis("pressure_asked", tuple(range(len(runs))), "1", "pressure"),
        Axis("replica", (0,), "1", "replica"),
    )
    points = [SimpleNamespace(scene=None) for _ in runs]
    sweep = SimpleNamespace(name="slabs", axes=axes, points=points, series=("kT",), derived=())
    return collect(sweep, [None] * len(runs))


def test_slices_of_boxes_that_change_keep_their_places(monkeypatch):
    """The profile stays, with the places of each run beside it; what is alike is a coordinate."""
    data = collected(monkeypatch, run(0.25, 1), run(0.26, 2))
    profile = data.density_profile
    assert profile.dims == ("pressure_asked", "replica", "block", "species", "z")
    assert profile.values[:, 0, 0, 0, 0].tolist() == [1, 2]
    assert "z" not in data.coords
    assert data.z_of_run.dims == ("pressure_asked", "replica", "z")
    assert data.z_of_run.values[:, 0, 0] == pytest.approx([0.125, 0.13])
    assert list(data.species.values) == ["A", "B"]


def test_slices_of_one_box_are_a_coordinate(monkeypatch):
    """As those of boxes that stay."""
    data = collected(monkeypatch, run(0.25, 1), run(0.25, 2))
    assert data.z.values[0] == pytest.approx(0.125)
    assert "z_of_run" not in data
