"""Figure 5: Flory-Huggins free energy and chemical potential with spinodals and binodals."""

import numpy as np
import xarray as xr

from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLACK, BLUE, RED, panels
from paper_figures.groot_warren_1997.flory_huggins import (
    binodal,
    chemical_potential,
    free_energy,
    spinodal,
)

PUBLISHED = shown_by(__file__)

TITLE = "Flory-Huggins free energy and chemical potential, N_A = N_B = 1."
PAPER_SHOWS = (
    "The paper shows (a) F and (b) mu = dF/dphi for a chi above the critical one, "
    f"{PUBLISHED['critical_chi']}, that it does not state (3 here), with spinodal points S, where "
    "mu is extremal, and binodal points B, the two coexisting compositions. No simulation enters."
)
ERRORS = "The curves are exact."
CHI = 3.0
# Where the letters of the marked points stand, in points from them, clear of the curves.
UPPER_LABELS = ((-3, 7), (-11, 3), (5, 3), (-3, 7))
LOWER_LABELS = ((4, -10), (-3, 5), (-3, -11), (-11, 4))


def compute(sweeps):
    """Curves and marked points."""
    phi = np.linspace(0.001, 0.999, 999)
    b, s = binodal(CHI), spinodal(CHI)
    marks = np.array([b, s, 1 - s, 1 - b])
    data = xr.Dataset(
        {
            "free_energy": ("phi", free_energy(phi, CHI)),
            "chemical_potential": ("phi", chemical_potential(phi, CHI)),
            "marked_phi": ("mark", marks),
        },
        {"phi": phi, "mark": ["B", "S", "S'", "B'"]},
        {"chi": CHI},
    )
    data.free_energy.attrs = {"units": "kT", "long_name": "F per site"}
    data.chemical_potential.attrs = {"units": "kT", "long_name": "dF/dphi per site"}
    data.marked_phi.attrs = {"units": "1", "long_name": "binodal and spinodal compositions"}
    return data


def measured(data):
    """The critical point: the smallest chi at which mu does not rise everywhere."""
    slope = np.gradient(chemical_potential(data.phi.values, 0), data.phi.values)
    note = "from the slope of mu without chi, to which chi adds -2 chi; Eq. 19 is not used"
    return {"critical_chi": Measured(float(slope.min() / 2), 0.0, note)}


def describe(data):
    """What is seen."""
    b, s = (float(data.marked_phi.sel(mark=name)) for name in "BS")
    return (
        f"Two curves over the fraction of A at chi = {data.attrs['chi']:g}. The free energy has "
        f"two minima, at {b:.2f} and {1 - b:.2f}, with a hump between; the chemical potential "
        f"crosses zero at both and has its extrema at {s:.2f} and {1 - s:.2f}."
    )


def draw(data):
    """Free energy above, chemical potential below, one axis."""
    figure, (upper, lower) = panels(rows=2, height=1.8, sharex=True)
    curves = (
        (upper, data.free_energy, free_energy, BLUE, r"$F$ / $k_BT$", UPPER_LABELS),
        (lower, data.chemical_potential, chemical_potential, RED, r"$\mu$ / $k_BT$", LOWER_LABELS),
    )
    for axes, curve, function, color, label, places in curves:
        axes.plot(data.phi, curve, color=color)
        for name, phi, place in zip(data.mark.values, data.marked_phi.values, places):
            y = float(function(phi, data.attrs["chi"]))
            axes.plot(phi, y, "o", color=BLACK, markersize=3)
            axes.annotate(str(name)[0], (phi, y), place, textcoords="offset points")
        axes.set_ylabel(label)
    lower.axhline(0, color=BLACK, linewidth=0.5)
    lower.set(xlim=(0, 1), ylim=(-1.6, 1.6), xlabel=r"fraction $\phi_A$")
    upper.text(0.5, 0.06, rf"$\chi$ = {data.attrs['chi']:g}, $N_A = N_B = 1$", ha="center",
               transform=upper.transAxes)  # fmt: skip
    return figure
