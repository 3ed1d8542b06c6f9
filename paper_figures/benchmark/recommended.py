"""physics/common/automatic.yaml: which scheme and step `integrator: {scheme: auto}` tries first."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dpd.analysis.collect import load
from dpd.errors import UserError
from paper_figures.benchmark.accuracy import choices, in_percent

if TYPE_CHECKING:
    from pathlib import Path

HEAD = """\
# What `integrator: {scheme: auto}` tries first: the cheapest scheme and step, on one core, whose
# errors in pressure and in kT are within the tolerance, each with 97.5 % confidence. (Pressure may
# be right by two errors that cancel. Lowe-Andersen, whose friction is another, is left out.)
# Measured by the benchmark, snakemake --cores 2 benchmark:
# python -m benchmarks schemes quick -o src/dpd/physics/common/automatic.yaml
# stiffness: a rho and C of the systems that it was measured in."""
STIFFNESS = {"fluid": "{repulsion: 75}", "melt": "{repulsion: 100, bond: 200}"}


def recommendations(figures: Path) -> str:
    """The file, from a folder with the figures ``fluid_accuracy`` and ``melt_accuracy``."""
    parts = [HEAD]
    for system, stiffness in STIFFNESS.items():
        path = figures / f"{system}_accuracy.nc"
        if not path.is_file():
            raise UserError(f"{path}: there is no such file; run snakemake --cores 2 benchmark")
        parts.append(f"{system}:\n  stiffness: {stiffness}\n  choices:")
        data = load(path)
        measured = choices(data.drop_sel(scheme="lowe-andersen", errors="ignore"))
        parts += [_line(choice) for choice in measured if choice.scheme is not None]
    return "\n".join(parts) + "\n"


def _line(choice):
    """One choice as YAML, and in a comment what it was chosen by."""
    scheme, _, prediction = choice.scheme.partition("-0.")
    chosen = f"scheme: {scheme}, lambda: 0.{prediction or 5}, dt: {choice.dt:g}"
    errors = in_percent(choice.deviations)
    return (
        f"    - {{gamma: {choice.gamma:g}, tolerance: {choice.tolerance:g}, {chosen}}}"
        f"  # p {errors['pressure']} %, kT {errors['kT']} %, {1000 * choice.seconds:.3g} ms per tau"
    )
