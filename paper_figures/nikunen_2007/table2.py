"""Table II and the mean bond lengths, over chain length: what the ends of chains change."""

import numpy as np
import xarray as xr

from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLACK, MARKERS, Look, panels, points
from paper_figures.nikunen_2007.chain_lengths import end_effect
from paper_figures.nikunen_2007.shared import (
    CONTROL,
    LABELS,
    PAPER_LENGTH,
    SETS,
    bond_statistics,
    criterion,
    repulsion,
)

PUBLISHED = shown_by(__file__)
HALF_DIGIT = 1e3 * PUBLISHED["r_min_a50"].rounding  # half of the last digit, in thousandths of r_c

TITLE = "Table II and mean bond lengths over the inverse chain length."
PAPER_SHOWS = (
    "The paper's Table II has (a) r_min and (b) l_max for N = 256, and its text has (c) the mean "
    "bond length and (d) its rms deviation. Drawn: ours less the published value, so that "
    "agreement is 0. Star, dashed lines: the published value at N = 256 and half of its last digit."
    " Near the ends of a chain beads and bonds are distributed otherwise; each chain has two ends, "
    "so means over bonds are linear in 1 / (N - 1) and means over beads in 1 / N. Lines: weighted "
    "fits; hollow at N = 256: the fit there, where no run has that length. Points and lines of the "
    "sets stand side by side for legibility."
)
ERRORS = "Bars: 95 % intervals; r_min and l_max by leaving out blocks, the others by blocking."
PRINTED = [name for name in SETS if name != CONTROL]  # the sets of Table II
CURVED = 0.01  # p-value below which a straight line is doubted


def _share(quantity, length):
    """What the quantity is linear in: ends per bead for g(r), per bond for the others."""
    return 1.0 / (length if quantity == "r_min" else length - 1.0)


def compute(sweeps):
    """The four quantities of every set and length, and at N = 256 by a straight line."""
    used = ["rdf", "bond_density", "bond_mean", "bond_mean_square"]  # each costs at every point
    runs = sweeps["statics"][used].sortby("length")
    shape = (runs.sizes["set"], runs.sizes["length"])
    table = np.full((*shape, len(LABELS), 2), np.nan)
    for place in np.ndindex(shape):
        at = runs.isel(set=place[0], length=place[1])
        table[place] = [*criterion(at), *bond_statistics(at)]
    length = runs.length.values.astype(float)
    fits = np.array([
        [
            end_effect(_share(name, length), *table[k, :, q].T, _share(name, PAPER_LENGTH))
            for q, name in enumerate(LABELS)
        ]
        for k in range(shape[0])
    ])  # fmt: skip
    along = ("set", "length", "quantity")
    return xr.Dataset(
        {
            "value": (along, table[..., 0], {"units": "r_c"}),
            "error": (along, table[..., 1], {"units": "r_c"}),
            "fitted": (along[::2], fits[..., 0], {"units": "r_c", "long_name": "fit at N = 256"}),
            "fitted_error": (along[::2], fits[..., 1], {"units": "r_c"}),
            "slope": (along[::2], fits[..., 2], {"units": "r_c", "long_name": "per share of ends"}),
            "slope_error": (along[::2], fits[..., 3], {"units": "r_c"}),
            "p_value": (along[::2], fits[..., 4], {"units": "1", "long_name": "of the line"}),
        },
        {"set": runs.set, "length": length, "quantity": list(LABELS)},
    )


def measured(data):
    """Each number at N = 256: of runs, where the study has them, or by the line."""
    found = {}
    for name in PRINTED:
        for quantity in LABELS:
            if name in data.set.values:
                at = data.sel(set=name, quantity=quantity)
                found[f"{quantity}_{name}"] = _at_published_length(at)
            else:
                found[f"{quantity}_{name}"] = Measured(np.nan, np.nan)
    return found


def _at_published_length(at):
    """Value and error of one quantity of one set."""
    lengths = ", ".join(f"{n:g}" for n in at.length.values)
    line = (
        f"line through N {lengths}: {float(at.fitted):.5f} ± {float(at.fitted_error):.5f} at N "
        f"{PAPER_LENGTH}; points scatter about a line as much or more with probability "
        f"{float(at.p_value):.2f}"
    )
    if PAPER_LENGTH in at.length.values:
        run = at.sel(length=PAPER_LENGTH)
        return Measured(float(run.value), float(run.error), f"runs of N 256; {line}")
    longest = at.isel(length=-1)
    if not np.isfinite(at.fitted):
        few = f"fewer than three lengths for a line to N 256; {float(longest.value):.4f} at N "
        return Measured(np.nan, np.nan, "", f"{few}{float(longest.length):g}")
    note = f"{line}; {float(longest.value):.4f} at N {float(longest.length):g}"
    return Measured(float(at.fitted), float(at.fitted_error), note)


def warnings(data):
    """Lines that the points do not follow."""
    p = data.p_value.to_series()
    curved = [f"{quantity} of {name} (p {value:.1g})" for (name, quantity), value in p.items()
              if value < CURVED]  # fmt: skip
    if not curved:
        return []
    return [f"Points scatter more about the line than their errors allow: {', '.join(curved)}."]


def describe(data):
    """What is seen."""
    change = data.slope * (1 / PAPER_LENGTH - 1 / 8)
    return (
        "Four panels of points that lie on straight lines over 1/N and end near zero at N = 256; "
        f"from N = 8 to 256 r_min rises by {_thousandths(change, 'r_min')}, l_max by "
        f"{_thousandths(change, 'l_max')} thousandths of r_c."
    )


def _thousandths(change, quantity):
    """Range over the published sets."""
    values = 1e3 * change.sel(quantity=quantity).values
    values = values[np.isfinite(values)]
    return f"{values.min():.0f} to {values.max():.0f}" if len(values) else "an unknown number of"


def draw(data):
    """A panel per quantity, the published sets in each."""
    figure, axes = panels(2, rows=2, height=2.3)
    sets = [name for name in PRINTED if name in data.set.values]
    for panel, (quantity, label) in zip(axes.flat, LABELS.items()):
        for k, name in enumerate(sets):
            at = data.sel(set=name, quantity=quantity)
            aside = 0.0012 * (k - 0.5 * (len(sets) - 1))
            look = Look(f"a = {repulsion(name)}", SETS[name], MARKERS[k])
            _draw_set(panel, at, PUBLISHED[f"{quantity}_{name}"].value, aside, look)
        for level in (-HALF_DIGIT, HALF_DIGIT):
            panel.axhline(level, color=BLACK, linestyle=(0, (4, 2)), linewidth=0.6, zorder=0)
        panel.plot(_share(quantity, PAPER_LENGTH), 0, "*", color=BLACK, ms=9, mfc="none", zorder=4)
        ends = "1 / N" if quantity == "r_min" else "1 / (N − 1)"
        panel.set(xlim=(0, None), xlabel=ends, ylabel=f"{label} less published / $10^{{-3}}$ $r_c$")
    axes[0, 0].legend(loc="lower left")
    return figure


def _draw_set(panel, at, printed, aside, look):
    """Points, line, and the line at N = 256."""
    quantity = at["quantity"].item()
    share, there = _share(quantity, at.length.values), _share(quantity, PAPER_LENGTH)
    above = 1e3 * (at.value - printed)
    points(panel, share + aside, above, 1e3 * at.error, *look)
    if not np.isfinite(at.fitted):
        return
    x = np.array([0, share.max()])
    line = float(at.fitted) + float(at.slope) * (x - there) - printed
    panel.plot(x + aside, 1e3 * line, color=look.color, linewidth=0.8)
    if PAPER_LENGTH not in at.length.values:
        points(panel, [there + aside], [1e3 * (float(at.fitted) - printed)],
               [1e3 * float(at.fitted_error)], None, look.color, look.marker,
               filled=False)  # fmt: skip
