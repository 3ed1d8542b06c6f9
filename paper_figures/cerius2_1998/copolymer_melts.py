"""Melts of A 5 B 5 and A 3 B 7: their phases by the peaks of the structure factor."""

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib import pyplot as plt

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import taped
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLACK, BLUE, DOUBLE, RED
from paper_figures.cerius2_1998.phases import CYLINDERS, LAMELLAE, phase_of, strengths_of
from paper_figures.cerius2_1998.shared import draw_isodensity

SLOPE = shown_by(__file__)["chi_slope_chains"].value
SHOWN = 4.5  # chi of the melts that are drawn: chi N is 45
SETTLED = 0.5  # share of a run that is left out at its beginning
CLOSE = 1e-6  # 1 / r_c by which equal wave vectors differ by rounding


class Melt:
    """A copolymer: its sweep, the phase that Groot and Madden found, and where its peaks are."""

    def __init__(self, sweep, name, phase, orders, labels):
        self.sweep, self.name, self.phase = sweep, name, phase
        self.orders, self.labels = orders, labels


MELTS = (
    Melt("symmetric", "A 5 B 5", LAMELLAE, (1, 2, 3), ("1", "2", "3")),
    Melt(
        "asymmetric", "A 3 B 7", CYLINDERS, (1, 3**0.5, 2, 7**0.5),
        ("1", r"$\sqrt{3}$", "2", r"$\sqrt{7}$"),
    ),
)  # fmt: skip

TITLE = "Melts of A 5 B 5 and A 3 B 7: domains of A and strengths of the wave vectors."
PAPER_SHOWS = (
    f"Not in the manual, whose chi N kT / Delta a = {SLOPE:g} N gives the repulsions: of chains of "
    "10 beads, chi N = 30, 45 and 60 are a_AB - 25 = 9.8, 14.7 and 19.6. (It was measured with a "
    "spring constant of 2; here that is 4.) Groot and Madden (1998) found layers in A 5 B 5 and "
    "hexagonal cylinders in A 3 B 7 at a_AB = 40. Drawn is chi N = 45. "
    "Top: bodies in which the density of A is more than half of all. Bottom: S_AA / N_A of each "
    "wave vector of the box, over the length of the strongest; in color those that are sums of the "
    "strongest, in gray all others. Lines are the peaks of layers, 1 : 2 : 3, and of cylinders, "
    "1 : sqrt(3) : 2 : sqrt(7). Layers of equal thickness have no peak at "
    "2, and cylinders that fill 0.3 of the box have weak ones at sqrt(3) and 2. The table names "
    "the phase of each run. It counts a peak that stands above all other wave vectors of about its "
    "length, where there are four of them or more."
)
ERRORS = (
    "Strengths are means over the second half of one run. Boxes are chosen to fit the distance of "
    "layers and of cylinders; the direction in which they lie is not."
)


def compute(sweeps):
    """Phases of all runs, and strengths and the last field of those that are drawn."""
    parts = {}
    for melt in MELTS:
        runs = sweeps[melt.sweep]
        chis = runs.chi.values
        phases = [[_phase(runs, chi, k) for k in range(runs.sizes["replica"])] for chi in chis]
        at = runs.sel(chi=SHOWN if SHOWN in chis else chis[-1])
        scene = first_scene(at)
        found = strengths_of(at.isel(replica=[0]), "A", SETTLED)
        length = np.linalg.norm(found.vectors, axis=1)
        first = phase_of(found).first
        field = at.density_field.isel(replica=0, frame=-1).values[scene.species.index("A")]
        name = melt.sweep
        parts |= {
            f"{name}_phase": (("chi", "replica"), [[p.name for p in row] for row in phases]),
            f"{name}_reason": (("chi", "replica"), [[p.reason for p in row] for row in phases]),
            f"{name}_spacing": (
                ("chi", "replica"), [[p.spacing for p in row] for row in phases], {"units": "r_c"},
            ),
            f"{name}_repulsion": ("chi", [_unlike(runs, c) for c in chis], {"units": "kT / r_c"}),
            f"{name}_length": (f"{name}_wave", length, {"units": "1 / r_c"}),
            f"{name}_strength": (f"{name}_wave", found.strength, {"units": "1"}),
            f"{name}_peak": (f"{name}_wave", on_lattice(found.vectors, first).astype(np.int8)),
            f"{name}_field": (
                tuple(f"{name}_{axis}" for axis in "xyz"), field, {"units": "1 / r_c^3"},
            ),
            f"{name}_edge": ("axis", np.array(scene.box), {"units": "r_c"}),
            f"{name}_drawn": ((), float(at.chi) * len(scene.molecules[0].beads), {"units": "1"}),
        }  # fmt: skip
    return xr.Dataset(parts, {"chi": ("chi", chis, {"units": "1"})})


def on_lattice(vectors, first):
    """Which wave vectors are whole-numbered sums of the strongest ones.

    ``vectors``: (n, 3) array. ``first``: (m, 3) array; the strongest ones: of layers one, of
    cylinders three, whose third is a sum of the others. Result: (n,) array of bool.
    """
    if len(first) not in (1, 3):
        return np.zeros(len(vectors), bool)
    basis = first[: 1 if len(first) == 1 else 2]
    numbers = np.round(vectors @ np.linalg.pinv(basis))
    return np.abs(numbers @ basis - vectors).max(axis=1) < CLOSE


@taped
def _phase(runs, chi, replica):
    """Of one run."""
    return phase_of(strengths_of(runs.sel(chi=chi).isel(replica=[replica]), "A", SETTLED))


def _unlike(runs, chi):
    """a_AB."""
    return float(first_scene(runs.sel(chi=chi)).repulsion[0, 1])


def measured(data):
    """The share of runs in the phase that Groot and Madden found, at chi N of 45 and more."""
    found = {}
    for melt in MELTS:
        names = data[f"{melt.sweep}_phase"].sel(chi=slice(SHOWN, None)).values.ravel()
        share = float((names == melt.phase).mean())
        others = sorted(set(names) - {melt.phase})
        spacing = float(data[f"{melt.sweep}_spacing"].sel(chi=slice(SHOWN, None)).mean())
        note = f"{(names == melt.phase).sum()} of {len(names)} runs"
        note += f", {spacing:.2f} r_c apart, as the box allows" if np.isfinite(spacing) else ""
        note += f"; the others: {', '.join(others)}" if others else ""
        undecided = ""
        if share < 0.5 and set(others) <= {"none", "disordered"}:
            undecided = "most of these short runs have not come to a phase whose peaks name it"
        found[melt.sweep] = Measured(share, 0.0, note, undecided)
    return found


def table(data):
    """The phase of each run."""
    rows = [
        {
            "melt": melt.name,
            "chi N": f"{10 * float(chi):g}",
            "a_AB": f"{float(data[f'{melt.sweep}_repulsion'].sel(chi=chi)):.2f}",
            "run": f"{k + 1}",
            "phase": str(data[f"{melt.sweep}_phase"].sel(chi=chi)[k].values),
            "why": str(data[f"{melt.sweep}_reason"].sel(chi=chi)[k].values),
        }
        for melt in MELTS
        for chi in data.chi.values
        for k in range(data.sizes["replica"])
    ]
    return pd.DataFrame(rows)


def describe(data):
    """What is seen."""
    return (
        "A 5 B 5 has flat layers of A, and its structure factor a strong peak at one wave vector "
        "and its threefold; A 3 B 7 has parallel cylinders of A, and three strong wave vectors, "
        "with weaker peaks where a hexagonal lattice has them."
    )


def draw(data):
    """Domains above, strengths below."""
    figure = plt.figure(figsize=(DOUBLE, 4.6))
    grid = figure.add_gridspec(2, len(MELTS), height_ratios=(1.15, 1))
    for k, (melt, color) in enumerate(zip(MELTS, (BLUE, RED))):
        solid = figure.add_subplot(grid[0, k], projection="3d")
        field = data[f"{melt.sweep}_field"].values
        draw_isodensity(solid, field, 1.5, data[f"{melt.sweep}_edge"].values, color)
        drawn = float(data[f"{melt.sweep}_drawn"])
        solid.set_title(rf"({'ab'[k]}) {melt.name}, $\chi N$ = {drawn:g}", loc="left")
        axes = figure.add_subplot(grid[1, k])
        axes.set_title(f"({'cd'[k]})", loc="left")
        _strengths(axes, data, melt, color)
    return figure


def _strengths(axes, data, melt, color):
    """Strengths over the length of wave vectors, and where peaks should be."""
    length = data[f"{melt.sweep}_length"].values
    strength = data[f"{melt.sweep}_strength"].values
    first = length[strength.argmax()]
    peak = data[f"{melt.sweep}_peak"].values == 1
    for which, shade, size in ((~peak, "0.6", 2), (peak, color, 3.5)):
        axes.plot(
            length[which] / first, strength[which], color=shade, marker="o", markersize=size,
            linestyle="none",
        )  # fmt: skip
    axes.set(yscale="log", xlim=(0.4, 3.4), xlabel="$q$ / $q_1$", ylabel=r"$S_{AA}(q)$ / $N_A$")
    axes.set_ylim(0.5 * strength[length < 3.4 * first].min(), 3)
    for order, label in zip(melt.orders, melt.labels):
        axes.axvline(order, color=BLACK, linewidth=0.6, linestyle=":", zorder=0)
        axes.text(order + 0.03, 1.2, label)
