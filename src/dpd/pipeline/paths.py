"""Where results lie, what made them, and what failed; the rules name files by it.

results/STUDY/PAPER/runs/SWEEP/POINT/run.nc
results/STUDY/PAPER/sweeps/SWEEP.nc
results/STUDY/report.html
"""

import platform
import subprocess
from dataclasses import dataclass
from pathlib import Path

from dpd.errors import FAILED
from dpd.folders import ROOT

RESULTS = "results"
LONG_STUDY = "paper"  # kept in git with its figures; its values stand beside those of every study
LIBRARIES = ("numpy", "numba", "scipy", "pandas", "matplotlib", "xarray", "netCDF4", "snakemake")


def run_file(folder: str | Path, point: str) -> str:
    """The result of a run below the folder of its sweep's runs."""
    return f"{folder}/{point}/run.nc"


@dataclass(frozen=True)
class Results:
    """Files of a study, as text: a part of a name may be a wildcard of Snakemake or a shell."""

    folder: str

    def compiled(self, paper: str, kernels: str) -> str:
        """A list of kernels that were compiled for a paper, by the digest of their sources."""
        return f"{self.folder}/{paper}/compiled/{kernels}.txt"

    def start(self, paper: str, digest: str) -> str:
        """A first configuration that runs share, by its digest."""
        return f"{self.folder}/{paper}/starts/{digest}.nc"

    def runs(self, paper: str, sweep: str) -> str:
        return f"{self.folder}/{paper}/runs/{sweep}"

    def run(self, paper: str, sweep: str, point: str) -> str:
        return run_file(self.runs(paper, sweep), point)

    def batch(self, paper: str, sweep: str, number: str) -> str:
        """A stamp that the runs that share a job are done."""
        return f"{self.runs(paper, sweep)}/{number}.made"

    def sweep(self, paper: str, sweep: str) -> str:
        return f"{self.folder}/{paper}/sweeps/{sweep}.nc"

    def measurement(self, paper: str, name: str) -> str:
        return f"{self.folder}/{paper}/measurements/{name}.nc"

    def figures(self, paper: str) -> str:
        return f"{self.folder}/{paper}/figures"

    def figure(self, paper: str, figure: str, kind: str) -> str:
        """A file of a figure: png, pdf, nc (its numbers), csv (verdicts) or html (caption)."""
        return f"{self.figures(paper)}/{figure}.{kind}"

    def report(self, suffix: str = "") -> str:
        return f"{self.folder}/report{suffix}.html"

    def verdicts(self, suffix: str = "") -> str:
        return f"{self.folder}/verdicts{suffix}.csv"

    def benchmark(self) -> str:
        return f"{self.folder}/benchmark.html"

    @property
    def logs(self) -> str:
        """Folder of what the jobs said."""
        return f"{self.folder}/logs"

    def log(self, *parts: str, kind: str = "log") -> str:
        """What a job said, or a stamp that it is done."""
        return f"{self.logs}/{'/'.join(parts)}.{kind}"


def results_of(study: str) -> Results:
    """The `Results` of a study, below the folder that snakemake works in."""
    return Results(f"{RESULTS}/{study}")


def errors_in(logs: str | Path, begun: float = 0.0) -> dict[str, Path]:
    """Sentences of jobs that failed, each with its first log; of none from before ``begun``."""
    found: dict[str, Path] = {}
    for path in sorted(Path(logs).rglob("*.log")):
        if path.stat().st_mtime >= begun:
            for line in path.read_text(errors="replace").splitlines():
                if line.startswith(FAILED):
                    found.setdefault(line, path)
    return found


def library_versions() -> dict[str, str]:
    """Version of each library and of Python, by name."""
    from importlib.metadata import version

    return {name: version(name) for name in LIBRARIES} | {"Python": platform.python_version()}


def commit() -> str:
    """The commit that the sources stand on, with a mark if they were edited."""
    command = ["git", "describe", "--always", "--dirty"]
    try:
        found = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    except OSError:
        return "unknown: git not found"
    return found.stdout.strip() or "not under version control"


def processor() -> str:
    """What the machine calls its processor."""
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()
