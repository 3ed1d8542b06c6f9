"""The site: `make docs` builds it into docs/_build/html, without network."""

import os
import sys
from importlib import import_module
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))
os.environ |= {  # of the cells of tutorials
    "DPD_PAPERS": str(ROOT),
    "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
    "PYTHONPATH": str(ROOT / "src"),
    "TQDM_DISABLE": "1",
}

from docs.papers import write_paper_pages  # noqa: E402
from docs.site import check_links, fill_page  # noqa: E402
from dpd import __version__  # noqa: E402

project = "dpd-papers"
author = "the authors of dpd-papers"
version = release = __version__
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
include_patterns = ["index.md", "gallery.md", "*/*.md"]
exclude_patterns = ["_build"]
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = f"dpd-papers {__version__}"
# MathJax as a package has it, for the site fetches nothing.
html_static_path = [f"{import_module('sphinx-mathjax-offline').__path__[0]}/static"]
mathjax_path = "mathjax/tex-chtml.js"
html_copy_source = html_show_copyright = False
default_role = "py:obj"
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # numpydoc says what they are
# Cells run in a folder of their own, and again only if a page was edited.
nb_execution_mode = "cache"
nb_execution_in_temp = True
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_merge_streams = True


def setup(app):
    """Tables come from the sources, pages of papers from the templates of the report."""
    app.connect("source-read", fill_page)
    app.connect("build-finished", finish)


def finish(app, problem):
    """Write what is no page of Sphinx, and look whether all links lead somewhere."""
    if problem is None:
        write_paper_pages(Path(app.outdir, "papers"))
        check_links(Path(app.outdir))
