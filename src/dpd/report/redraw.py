"""Draw figures of an archive again, and judge their numbers, where their runs are not at hand."""

from __future__ import annotations

from functools import partial
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from matplotlib import pyplot as plt
from PIL import Image

from dpd.analysis.collect import load
from dpd.errors import UserError
from dpd.files import replace_whole
from dpd.pipeline.study import read_study
from dpd.report.archive import ARCHIVE
from dpd.report.figure_file import load_module
from dpd.report.figures import drawing, joined, judged
from dpd.report.manifest import MANIFEST, checksum, manifest_of, manifest_text
from dpd.report.whole_archive import VERDICTS, small_png

if TYPE_CHECKING:
    import pandas as pd


class Redrawn(NamedTuple):
    """What becomes of archived numbers: the picture, as PNG, and the verdicts."""

    picture: bytes
    verdicts: pd.DataFrame


def redraw(study: str) -> list[Path]:
    """Draw and judge again what an archive keeps the numbers of.

    After an edit of a figure file or of a published number. What those files calculate from sweeps
    stays as it was.

    Parameters
    ----------
    study : str

    Returns
    -------
    list of path
        What has changed.

    Raises
    ------
    UserError
        If there is no such study, its archive keeps no figures, or a figure file does not
        understand the numbers. Then nothing changes.
    """
    read_study(study)  # a name that is none would lead elsewhere
    target, manifest = ARCHIVE / study, manifest_of(study)
    if not manifest:
        raise UserError(f"{target / MANIFEST}: missing; no figures are archived")
    made = {name: redrawn(name, target / f"{name}.nc") for name in manifest["figures"]}
    table = joined(one.verdicts for one in made.values())
    contents = {f"{name}.png": one.picture for name, one in made.items()}
    contents[VERDICTS] = table.to_csv(index=False).encode()
    manifest["files"] |= {name: checksum(data) for name, data in contents.items()}
    contents[MANIFEST] = manifest_text(manifest).encode()
    changed = [name for name, data in contents.items() if data != (target / name).read_bytes()]
    for name in changed:
        replace_whole(target / name, partial(Path.write_bytes, data=contents[name]))
    return [target / name for name in changed]


def redrawn(name: str, numbers: Path) -> Redrawn:
    """A figure, from the file with its numbers.

    Parameters
    ----------
    name : str
        ``paper/figure``.
    numbers : path
    """
    paper, figure = name.split("/")
    module, data = load_module(paper, figure), load(numbers)
    return Redrawn(_picture(module, data), judged(module, paper, figure, data))


def _picture(module, data):
    drawn, whole = drawing(module, data), BytesIO()
    drawn.savefig(whole, format="png")
    plt.close(drawn)
    with Image.open(whole) as picture:
        return small_png(picture)
