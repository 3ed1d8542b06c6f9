"""Pressure and excess properties of two fluids and their mixtures, for Figures 5 and 6."""

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import taped
from dpd.report.style import points
from paper_figures.crgw_2019.shared import LOOKS, PERCENT, TARGET, mean_of, mean_of_alike

EXCESSES = {
    "enthalpy": "excess enthalpy / %",
    "energy": "excess energy / %",
    "volume": "excess volume / %",
}


def mixture(sweeps, one, other):
    """A mixture of two fluids over the mole fraction of the first.

    ``sweeps``: with the sweeps of both fluids and of the mixture, at constant volume and pressure.
    ``one``, ``other``: names of the fluids. Result: over ``equation`` and ``share``:
    ``pressure_off`` at constant volume, and the excess ``enthalpy``, ``energy`` and ``volume`` at
    constant pressure over the values of ideal mixing, all in percent and each with its ``_error``.
    """
    pressure, error = _joined(sweeps, one, other, "", lambda runs: mean_of(runs, "pressure"))
    found = {
        "pressure_off": 100 * (pressure / TARGET - 1),
        "pressure_off_error": 100 / TARGET * error,
    }
    mixed = sweeps[f"{one}_{other}"]
    shares = np.array([0.0, *mixed.share.values, 1.0])
    share = shares[:, np.newaxis]
    for name in EXCESSES:
        value, error = _joined(sweeps, one, other, "_npt", MEASURES[name])
        ideal = share * value[-1] + (1 - share) * value[0]
        inside = (share > 0) & (share < 1)
        spread = np.sqrt(error**2 + (share * error[-1]) ** 2 + ((1 - share) * error[0]) ** 2)
        found[name] = 100 * (value / ideal - 1)
        found[f"{name}_error"] = np.where(inside, 100 * spread / abs(ideal), 0.0)
    along, coordinates = ("share", "equation"), {"share": shares, "equation": mixed.equation}
    return xr.Dataset({name: (along, each, PERCENT) for name, each in found.items()}, coordinates)


def _joined(sweeps, one, other, ensemble, measure):
    """A value and its error over all mole fractions and equations, with those of pure fluids."""
    pairs = [measure(sweeps[name + ensemble]) for name in (other, f"{one}_{other}", one)]
    return tuple(
        np.vstack([part.transpose(..., "equation").values for part in parts])
        for parts in zip(*pairs)
    )


def _per_molecule(runs):
    """Number of molecules of a run."""
    return float(sum(kind.count for kind in first_scene(runs).molecules))


def _per_molecule_of(**terms):
    """What gives a sum of series, each times a factor, per molecule, and its error.

    The error is that of the sum: where the volume grows, the energy of beads that repel each other
    falls. Single beads have no energy of bonds.
    """

    @taped
    def total(runs):
        known = [name for name in terms if f"{name}_series" in runs]
        return sum(terms[name] * runs[f"{name}_series"] for name in known) / _per_molecule(runs)

    return lambda runs: mean_of_alike(total(runs))


MEASURES = {
    "enthalpy": _per_molecule_of(pair_energy=1, bond_energy=1, volume=TARGET),
    "energy": _per_molecule_of(pair_energy=1, bond_energy=1),
    "volume": _per_molecule_of(volume=1),
}


def most(data, name, equation):
    """Largest unsigned value in percent over the mole fractions, and its standard error."""
    at = data.sel(equation=equation)
    place = int(np.abs(at[name].values).argmax())
    return abs(float(at[name][place])), float(at[f"{name}_error"][place])


def draw_mixture(axes, data, name, label):
    """One quantity of all equations over the mole fraction."""
    for equation, look in LOOKS.items():
        at = data.sel(equation=equation)
        points(axes, at.share, at[name], at[f"{name}_error"], look.label, look.color, look.marker,
               linestyle="-")  # fmt: skip
    axes.axhline(0, color="0.5", linewidth=0.6)
    axes.set(xlim=(-0.03, 1.03), ylabel=label)
