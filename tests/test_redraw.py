"""Archived figures are drawn and judged again from their numbers."""

import hashlib
import shutil

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from PIL import Image

from dpd.errors import UserError
from dpd.report import archive

STUDY, FIGURE = "paper", "nikunen_2007/fig05_exponents"
KEPT = archive.ARCHIVE / STUDY


@pytest.fixture
def one(tmp_path, monkeypatch):
    """An archive with one figure of those that git has."""
    said = archive.manifest_of(STUDY) | {"figures": {FIGURE: "here"}, "files": {}}
    monkeypatch.setattr(archive, "ARCHIVE", tmp_path)
    folder = tmp_path / STUDY
    (folder / FIGURE).parent.mkdir(parents=True)
    for kind in ("png", "nc"):
        shutil.copy(KEPT / f"{FIGURE}.{kind}", folder / f"{FIGURE}.{kind}")
    rows_of(KEPT).to_csv(folder / "verdicts.csv", index=False)
    (folder / "manifest.yaml").write_text(archive.manifest_text(said, {}))
    return folder


def rows_of(folder):
    """Verdicts on the numbers of that figure."""
    table = pd.read_csv(folder / "verdicts.csv")
    return table[table.figure == FIGURE.split("/")[1]].reset_index(drop=True)


def pixels(folder):
    """Of its picture."""
    return np.asarray(Image.open(folder / f"{FIGURE}.png").convert("RGB"))


def test_what_git_has_is_what_its_numbers_give(one):
    """Also after somebody has spoilt both: rows and picture come back, with their checksums."""
    table = rows_of(one)
    table["verdict"], table["value"] = "replicated", 1.0
    table.to_csv(one / "verdicts.csv", index=False)
    Image.new("RGB", (1, 1)).save(one / f"{FIGURE}.png")
    changed = archive.redraw(STUDY)
    names = [f"{FIGURE}.png", "verdicts.csv"]
    assert changed == [one / name for name in (*names, "manifest.yaml")]
    said = archive.manifest_of(STUDY)["files"]
    assert {name: said[name]["sha256"] for name in said} == {
        name: hashlib.sha256((one / name).read_bytes()).hexdigest() for name in names
    }
    pd.testing.assert_frame_equal(rows_of(one), rows_of(KEPT), rtol=1e-9)
    assert pixels(one).shape == pixels(KEPT).shape
    assert (np.abs(pixels(one).astype(int) - pixels(KEPT)) < 50).mean() > 0.99
    assert archive.redraw(STUDY) == []


def test_numbers_of_an_older_figure_are_refused(one):
    """In one sentence with the file; the archive stays as it was."""
    path = one / f"{FIGURE}.nc"
    with xr.open_dataset(path) as data:
        older = data.load().drop_vars("tau")
    older.to_netcdf(path)
    before = {path: path.read_bytes() for path in one.rglob("*") if path.is_file()}
    with pytest.raises(UserError, match=r"fig05_exponents.py: line \d+: .*tau"):
        archive.redraw(STUDY)
    assert {path: path.read_bytes() for path in one.rglob("*") if path.is_file()} == before


def test_an_archive_without_figures(one):
    """As that of a short study."""
    (one / "manifest.yaml").unlink()
    with pytest.raises(UserError, match=r"manifest.yaml: missing; no figures are archived"):
        archive.redraw(STUDY)
