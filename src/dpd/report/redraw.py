"""Draw figures of an archive again, and judge their numbers, where their runs are not at hand."""

from __future__ import annotations

from io import BytesIO
from typing import TYPE_CHECKING

from matplotlib import pyplot as plt
from PIL import Image

from dpd.analysis.collect import load
from dpd.errors import UserError
from dpd.pipeline.study import read_study
from dpd.report import archive
from dpd.report.figure_file import load_module
from dpd.report.figures import drawing, joined, judged

if TYPE_CHECKING:
    from pathlib import Path


def redraw(study: str) -> list[Path]:
    """Draw and judge again what an archive keeps the numbers of, and name what has changed.

    After an edit of a figure file or of a published number. What those files calculate from sweeps
    stays as it was.

    Raises
    ------
    UserError
        If there is no such study, its archive keeps no figures, or a figure file does not
        understand the numbers. Then nothing changes.
    """
    read_study(study)  # a name that is none would lead elsewhere
    target, manifest = archive.ARCHIVE / study, archive.manifest_of(study)
    if not manifest:
        raise UserError(f"{target / archive.MANIFEST}: missing; no figures are archived")
    contents, tables = {}, []
    for name in manifest["figures"]:
        paper, figure = name.split("/")
        module, data = load_module(paper, figure), load(target / f"{name}.nc")
        drawn, whole = drawing(module, data), BytesIO()
        drawn.savefig(whole, format="png")
        plt.close(drawn)
        with Image.open(whole) as picture:
            contents[f"{name}.png"] = archive.small_png(picture)
        tables.append(judged(module, paper, figure, data))
    contents[archive.VERDICTS] = joined(tables).to_csv(index=False).encode()
    contents[archive.MANIFEST] = archive.manifest_text(manifest, contents).encode()
    return archive.write_changed(target, contents)
