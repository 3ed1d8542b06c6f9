"""Figures 7 and S2: potential of a chain over that of its bead, predicted and simulated."""

import numpy as np
import xarray as xr

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import block_mean_and_error
from dpd.analysis.verdicts import Measured, shown_by
from dpd.errors import UserError
from dpd.report.style import BLACK, BLUE, RED, panels, points, published_line
from paper_figures.crgw_2019.mixing import chain_potential, monomer_potential

PUBLISHED = shown_by(__file__)
DIMERS = 23.39  # a_ij of Table III
BOND = 0.4  # r_c, of solutes of all lengths
FITTED = 0.6  # r_c, the longest bond to which Eq. 34 was fitted
OTHERS = {"solute_trimers": 15.74, "solute_tetramers": 17.73, "solute_hexamers": 7.33}
STUDIES = {
    "density": ("input density of the solvent / $r_c^{-3}$", RED, "o"),
    "chain": ("beads of the chain $m$", BLACK, "s"),
    "bond": ("bond length $l$ / $r_c$", BLUE, "D"),
}

TITLE = "Chemical potential of a chain over that of its bead: the prediction less the simulation."
PAPER_SHOWS = (
    "A chain is inserted into a fluid of beads at the pressure 41.89. The ratio of its excess "
    "chemical potential to that of one of its beads is compared with Eqs. 30 and 34, over the "
    "density of the solvent, the beads of the chain, and the bond length, the other two held. The "
    "paper says within 4 % (gray), from above zero for short chains to below it for long ones, and "
    "less at higher density. Here the energy of solute and solvent is integrated over their "
    "repulsion, from 0 to that of Table III. (d) The ratio itself of dimers, over m: the paper "
    "says that it approaches 1 as bonds grow (Eq. 32, dashed), and makes the functions of Eq. 34 "
    f"(line) for that, but fits their constants to bonds of up to {FITTED} alone."
)


def compute(sweeps):
    """Ratios of all solutes."""
    rows = []
    for density in sweeps["solute_densities"].density.values:
        rows.append(
            _row("density", density, sweeps["solute_densities"].sel(density=density), DIMERS)
        )
    for bond in sweeps["solute_bonds"].bond.values:
        rows.append(_row("bond", bond, sweeps["solute_bonds"].sel(bond=bond), DIMERS))
        if bond == BOND:
            rows.append(rows[-1] | {"study": "chain", "x": 2.0})
    for name, repulsion in OTHERS.items():
        rows.append(_row("chain", None, sweeps[name], repulsion))
    names = {"study": "1", "x": "1", "mu_chain": "kT", "mu_chain_error": "kT", "mu_bead": "kT",
             "mu_bead_error": "kT", "ratio": "1", "ratio_error": "1", "predicted": "1",
             "off": "%", "off_error": "%", "bead_predicted": "kT", "length": "r_c",
             "beads": "1", "repulsion": "kT / r_c", "density": "1 / r_c^3"}  # fmt: skip
    return xr.Dataset(
        {name: ("solute", [row[name] for row in rows], {"units": u}) for name, u in names.items()}
    )


def _row(study, x, runs, repulsion):
    """One solute: what is simulated, and what is predicted."""
    scene = first_scene(runs)
    solvent, chains, beads = scene.molecules
    m, bond = len(chains.beads), scene.data["bond"]["length"]
    # Solutes take up no room at the beginning of the integral, and that of their beads at its end.
    density = (solvent.count + 0.5 * (m * chains.count + beads.count)) / scene.volume
    chain, chain_error = _potential(runs, "S W", chains.count, repulsion)
    bead, bead_error = _potential(runs, "M W", beads.count, repulsion)
    ratio = chain / bead
    error = ratio * np.hypot(chain_error / chain, bead_error / bead)
    predicted = chain_potential(repulsion, density, m, bond) / monomer_potential(repulsion, density)
    return {
        "study": study, "x": float(m if x is None else x),
        "mu_chain": chain, "mu_chain_error": chain_error,
        "mu_bead": bead, "mu_bead_error": bead_error,
        "ratio": ratio, "ratio_error": error, "predicted": float(predicted),
        "off": 100 * (predicted / ratio - 1), "off_error": 100 * predicted / ratio**2 * error,
        "bead_predicted": float(monomer_potential(repulsion, density)), "length": bond,
        "beads": float(m), "repulsion": repulsion, "density": density,
    }  # fmt: skip


def _potential(runs, pair, count, repulsion):
    """Excess chemical potential by integration of <u> / a over a, and its error."""
    # A pair is named in the order of the species, which is that of the alphabet or of the scene.
    names = [str(name) for name in runs.energy_pair.values]
    name = pair if pair in names else " ".join(reversed(pair.split()))
    blocks = runs.energy_of_pair.sel(energy_pair=name).isel(replica=0) / count
    mean, error = block_mean_and_error(blocks.transpose("block", "coupling").values)
    strengths = runs.coupling.values.astype(float)
    nodes, weights = np.polynomial.legendre.leggauss(len(strengths))
    if not np.allclose(strengths, repulsion * (nodes + 1) / 2, rtol=1e-3):
        raise UserError(
            f"coupling: {', '.join(f'{a:g}' for a in strengths)} are not the points after Gauss "
            f"and Legendre from 0 to {repulsion:g}"
        )
    factor = weights * repulsion / 2 / strengths
    return float(factor @ mean), float(np.sqrt(((factor * error) ** 2).sum()))


def measured(data):
    """Errors of the ratio, its limit for long bonds, and single beads against Eq. 30."""
    fitted = data.isel(solute=np.flatnonzero(data.length <= FITTED))
    off, error = np.abs(fitted.off.values), fitted.off_error.values
    worst = int(off.argmax())
    at = fitted.isel(solute=worst)
    most = Measured(float(off[worst]), float(error[worst]), f"at {at.study.item()} {float(at.x):g}")
    _, own = np.unique(off, return_index=True)  # the same dimers are in several studies
    off, error = off[own], error[own]
    scatter = off.std(ddof=1) / np.sqrt(off.size) if off.size > 1 else np.nan
    _, once = np.unique(data.mu_bead.values, return_index=True)  # some dimers are in two studies
    bead = (data.bead_predicted.values / data.mu_bead.values - 1)[once]
    bead_error = (data.mu_bead_error.values / data.mu_bead.values)[once]
    place = int(np.abs(bead).argmax())
    return {
        "ratio_error": most,
        "ratio_most": most,
        "ratio_mean": Measured(
            float(off.mean()), float(np.hypot(scatter, np.sqrt((error**2).sum()) / off.size)),
            f"{off.size} solutes; the error is that of the choice of solutes, too",
            "the text's mean is over other solutes, which it does not list",
        ),
        **_apart(data),
        "ratio_over_chain": _change(data, "chain", "m"),
        "ratio_over_density": _change(data, "density", "density"),
        "bead_potential": Measured(
            100 * float(np.abs(bead).mean()),
            100 * float(np.sqrt((bead_error**2).sum()) / len(bead)),
            f"largest {100 * float(bead[place]):+.1f} %",
        ),
    }  # fmt: skip


def _apart(data):
    """The ratio of the longest bond over m, simulated and by Eq. 34."""
    longest = data.isel(solute=int(data.length.values.argmax()))
    if not longest.length > 1:
        return {name: Measured(np.nan, np.nan) for name in ("apart", "apart_fit")}
    m, said = float(longest.beads), f"m = {float(longest.beads):g}, l = {float(longest.length):g}"
    return {
        "apart": Measured(float(longest.ratio) / m, float(longest.ratio_error) / m, said),
        "apart_fit": Measured(float(longest.predicted) / m, 0.0, said),
    }


def _change(data, study, name):
    """The error at the last point of a study less that at the first."""
    at = data.where(data.study == study, drop=True)
    if at.sizes["solute"] < 2:
        return Measured(np.nan, np.nan)
    x, off, error = (at[key].values[[0, -1]].astype(float) for key in ("x", "off", "off_error"))
    return Measured(
        off[1] - off[0], float(np.hypot(*error)),
        f"{off[0]:+.1f} % at {name} = {x[0]:g}, {off[1]:+.1f} % at {x[1]:g}",
    )  # fmt: skip


def describe(data):
    """What is seen."""
    return (
        "Three panels of points about zero, within a band of 4 %, over density, length of chain, "
        "and bond length; in a fourth the ratio over m rises to one and stays there, while the "
        "line of the prediction goes on rising."
    )


def draw(data):
    """A panel for each study, and the ratio over the bond length."""
    figure, axes = panels(2, rows=2, height=2.2)
    bound = PUBLISHED["ratio_error"].high
    fitted = data.isel(solute=np.flatnonzero(data.length <= FITTED))
    reach = 1.1 * max(1.5 * bound, float((np.abs(fitted.off) + 2 * fitted.off_error).max()))
    for panel, (study, (label, color, marker)) in zip(axes.flat, STUDIES.items()):
        at = fitted.where(fitted.study == study, drop=True)
        panel.axhspan(-bound, bound, color="0.9", zorder=0)
        panel.axhline(0, color="0.5", linewidth=0.6)
        points(panel, at.x, at.off, at.off_error, None, color, marker)
        panel.set(xlabel=label, ylim=(-reach, reach))
    for panel in axes[:, 0]:
        panel.set(ylabel=r"$\mu$ ratio, predicted less simulated / %")
    ratio = axes[1, 1]
    at = data.where(data.study == "bond", drop=True)
    m, a, density = (float(at[name][0]) for name in ("beads", "repulsion", "density"))
    x = np.linspace(0.2, max(1.6, float(at.x.max())), 100)
    line = chain_potential(a, density, int(m), x) / monomer_potential(a, density) / m
    ratio.plot(x, line, color=BLUE, label="Eq. 34")
    published_line(ratio, x, np.ones_like(x), "Eq. 32")
    points(ratio, at.x, at.ratio / m, at.ratio_error / m, "this work", BLUE, "D")
    ratio.set(xlabel="bond length $l$ / $r_c$", ylabel=r"$\mu$ ratio over $m$")
    ratio.legend(loc="upper left")
    return figure
