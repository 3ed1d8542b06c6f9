"""Captions and numbers of the report."""

import os
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from dpd import files
from dpd.report import overhead
from dpd.report.figures import caption
from dpd.report.page import _html
from dpd.report.text import with_error

NUMBERS = [
    (0.12345, 0.0067, "0.1235 ± 0.0067"),
    (123.4, 5.6, "123.4 ± 5.6"),
    (12345.0, 678.0, "12345 ± 678"),
    (3.21e-6, 4.5e-8, "(3.210 ± 0.045)e-6"),
    (2.5e8, 1.0e7, "(2.50 ± 0.10)e8"),
    (0.0, 0.01, "0.000 ± 0.010"),
    (1.5, np.nan, "1.5"),
    (1.5, 0.0, "1.5"),
    (np.nan, 1.0, "–"),
]


@pytest.mark.parametrize("value, error, text", NUMBERS, ids=[text for _, _, text in NUMBERS])
def test_two_digits_of_the_error(value, error, text):
    """And the value to the same place."""
    assert with_error(value, error) == text


def test_warnings_and_table_of_a_figure():
    """They follow the caption, and come out as HTML with nothing left to the browser's mercy."""
    frame = pd.DataFrame([("a < b", "1 ± 2")], columns=["set", "rate / %"])
    module = SimpleNamespace(
        TITLE="Rates.", PAPER_SHOWS="None.", ERRORS="Bars.",
        warnings=lambda numbers: [f"Box {float(numbers.room)} is small."],
        table=lambda numbers: frame,
    )  # fmt: skip
    text = caption(module, {}, xr.Dataset({"room": 1.5}))
    assert "**Warning.** Box 1.5 is small." in text
    page = str(_html(text))
    assert "<strong>Warning.</strong> Box 1.5 is small." in page
    assert "<tr><th>set</th><th>rate / %</th></tr>" in page
    assert "<tr><td>a &lt; b</td><td>1 ± 2</td></tr>" in page
    assert "---" not in page


def test_a_figure_without_either():
    """Most have no warnings and no table."""
    module = SimpleNamespace(TITLE="Rates.", PAPER_SHOWS="None.", ERRORS="Bars.")
    assert caption(module, {}, xr.Dataset()) == "**Rates.** None.\n\nBars.\n"


def test_what_a_workflow_costs_beside_its_simulations(tmp_path, monkeypatch):
    """Runs, starts and measurements since it began, of all papers, and nothing older."""
    monkeypatch.setattr(overhead.time, "time", lambda: 1110.0)
    for number, name in enumerate(("a/runs/s/p/run.nc", "a/starts/0.nc", "b/runs/s/p/run.nc")):
        files.write(tmp_path / name, {}, {"seconds": 50.0 + number})
        os.utime(tmp_path / name, (1005.0, 1005.0))
    said = overhead.overhead(tmp_path, 1000.0, 2)
    assert said.startswith("simulation 153 s (runs and starts: 3), wall clock 110 s on 2 cores")
    assert ": 44% more" in said
    os.utime(tmp_path / "b/runs/s/p/run.nc", (999.0, 999.0))
    assert overhead.overhead(tmp_path, 1000.0, 2).startswith(
        "simulation 101 s (runs and starts: 2)"
    )
    assert ": 116% more" in overhead.overhead(tmp_path, 1000.0, 4)  # no faster than one run
    assert overhead.overhead(tmp_path, 1006.0, 2) == ""
    # Nothing runs beside a measurement: it takes all cores.
    files.write(tmp_path / "b/measurements/m.nc", {}, {"seconds": 40.0})
    said = overhead.overhead(tmp_path, 1000.0, 2)
    assert "measurements 40 s on all cores" in said and ": 21% more" in said
