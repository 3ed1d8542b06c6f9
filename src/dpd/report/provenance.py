"""What made a report or an archive: the commit of the sources and the versions of libraries."""

import platform
import subprocess
from importlib.metadata import version

from dpd.digest import ROOT

LIBRARIES = ("numpy", "numba", "scipy", "pandas", "matplotlib", "xarray", "netCDF4", "snakemake")


def library_versions() -> dict[str, str]:
    """Version of each library and of Python, by name."""
    return {name: version(name) for name in LIBRARIES} | {"Python": platform.python_version()}


def commit() -> str:
    """The commit that the sources stand on, with a mark if they were edited."""
    command = ["git", "describe", "--always", "--dirty"]
    try:
        found = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    except OSError:
        return "unknown: git not found"
    return found.stdout.strip() or "not under version control"
