"""The site: `make docs` builds it into docs/_build/html, without network."""

import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from docs.papers import archived_counts, write_paper_pages  # noqa: E402
from dpd import __version__  # noqa: E402

project = "dpd-papers"
author = "the authors of dpd-papers"
version = release = __version__
extensions = ["myst_parser"]
include_patterns = ["*.md"]
html_theme = "furo"
html_title = f"dpd-papers {__version__}"
html_copy_source = html_show_copyright = False


def setup(app):
    """Pages of papers are no pages of Sphinx: the report's templates write them beside these."""

    def fill(app, name, source):
        source[0] = source[0].replace("COUNTS", archived_counts())

    app.connect("source-read", fill)
    app.connect("build-finished", lambda app, _: write_paper_pages(Path(app.outdir, "papers")))
