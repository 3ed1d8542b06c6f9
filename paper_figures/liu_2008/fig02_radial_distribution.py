"""Figure 2: g(r) of monomers for several core radii, and how close they come."""

import numpy as np
import xarray as xr

from dpd.analysis.statistics import COVERAGE, block_mean_and_error, jackknife
from dpd.analysis.structure import contact, peak, radial_distribution, rise
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLACK, ORANGE, PURPLE, mpl, panels, points
from paper_figures.liu_2008.shared import CORES, at_radius, closest_contact, samples_of

PUBLISHED = shown_by(__file__)
CRYSTAL = PUBLISHED["crystal_radius"].value  # r_s at which the paper expects a crystal

TITLE = "Monomers with rigid cores (rho 2, a 25, F_max 100): g(r), and how close they come."
PAPER_SHOWS = (
    "The paper shows (a) for r_s = 0, 0.15, 0.20 and 0.25, and says where the first peak of r_s "
    f"{CRYSTAL:g} should be; 0.1 is ours. Dotted: published first peaks. (b) Closest contact 2 r_0 "
    "over 2 r_s: the lower edge of the first bin (0.01 r_c wide) of g(r) that is not empty in one "
    "configuration of 20 000 beads, median over 50 configurations. The line is 2 r_0 = 2 r_s. "
    "(c) The same for g(r) made of several configurations: the core is finite, so the first bin "
    "that is not empty keeps falling; hollow circles: one part alone, without an error. Hollow "
    "squares: where g = 0.05, which does not depend on sampling."
)
ERRORS = (
    "(a) and (c): 95 % intervals from blocks of the run. (b): the same of the median, "
    "interpolated within a bin. Peaks: a cubic through the bins within 0.15 r_c of its maximum, "
    "but no farther than two thirds of the way to the kink of g(r) at 2 r_s, where forces jump; "
    "errors by leaving out tenths of the run. At the kink it is the highest bin, and its error "
    "one bin."
)
COLORS = CORES | {CRYSTAL: PURPLE}
REACH = 2 / 3  # of the way to the kink: how far the fit of a peak reaches
WIDE, FLAT = 0.15, 0.01  # about a peak, in r_c; and share of its height that no eye tells
SHARES = (1 / 2, REACH, 5 / 6)  # other windows, to show that they do not matter
PARTS, LEAST = 4, 8  # of the run for the drift of 2 r_0, and configurations in each
RESTS = {0.15: 0.25, 0.25: 0.41}  # 2 r_0 in the bonds of sets (1) and (2)


def compute(sweeps):
    """g(r), peaks, and the distance of closest contact, for one configuration and for more."""
    runs = sweeps["monomers"][["scene", "rdf", "beads"]]
    r, r_s = runs.r.values, runs.r_s.values.astype(float)
    width = float(r[1] - r[0])
    curves, rows, windows, falling, slopes = [], [], [], [], []
    for radius in runs.r_s.values:
        at = runs.sel(r_s=radius)
        g, error, blocks = radial_distribution(at)
        curves.append((g, error))
        # Half of a last bin either way is as good as a peak at the kink is known.
        place, place_error = _peak(r, blocks, radius)
        highest = (place, max(place_error, width if _at_kink(r, g, radius) else 0.0))
        by_window = [_peak(r, blocks, radius, share) for share in SHARES]
        windows.append([value for value, _ in by_window])
        closest = jackknife(blocks, lambda mean: rise(r, mean))
        falling.append(contact_over_sampling(r, blocks, samples_of(at, "rdf") / len(blocks)))
        core = closest_contact(at)
        rows.append((*highest, *closest, core.value, core.error))
        slopes.append(_slopes(r, blocks))
    (samples, contacts, contact_errors), along = zip(*falling), ("r_s", "sampling")
    data = xr.Dataset(
        {
            "g": (("r_s", "r"), [g for g, _ in curves], {"units": "1", "long_name": "g(r)"}),
            "g_error": (("r_s", "r"), [e for _, e in curves], {"units": "1"}),
            "peak_by_window": (("r_s", "share"), windows, {"units": "r_c"}),
            "samples": (along, list(samples), {"units": "1"}),
            "contact_over_sampling": (along, list(contacts), {"units": "r_c"}),
            "contact_over_sampling_error": (along, list(contact_errors), {"units": "r_c"}),
        },
        {"r_s": ("r_s", r_s, {"units": "r_c"}), "r": runs.r, "share": list(SHARES)},
        {"undecided": core.undecided},
    )
    names = ("peak", "peak_error", "rise", "rise_error", "contact", "contact_error")
    for name, column in zip(names, np.array(rows).T):
        data[name] = ("r_s", column, {"units": "r_c"})
    drift, error = block_mean_and_error(np.transpose(slopes), alike=True)
    for name, values in (("drift", drift), ("drift_error", error)):
        data[name] = ("r_s", values, {"units": "r_c"})
    return data


def _peak(r, blocks, radius, share=REACH):
    """Place of the first peak and its error."""
    return jackknife(blocks, lambda mean: peak(r, mean, 2 * radius, share))


def _at_kink(r, g, radius):
    """Whether a peak stands so close to the kink that no curve is laid through it."""
    return peak(r, g, 2 * radius) == r[np.argmax(g)]


def _top(at, radius):
    """Between which distances a cubic about the peak is within `FLAT` of its height, in words."""
    place = float(at.peak)
    if not np.isfinite(place):
        return "nowhere that is known"
    start = max(place - WIDE, 2 * radius)
    near = (at.r > start) & (at.r < place + WIDE)
    cubic = np.polynomial.Polynomial.fit(at.r[near], at.g[near], 3)
    x = np.linspace(start, place + WIDE, 1000)
    flat = x[cubic(x) > (1 - FLAT) * cubic(place)]
    return f"from {flat.min():.2f} to {flat.max():.2f}" if len(flat) else "nowhere that is known"


def _slopes(r, blocks):
    """Change of the distance per decade of sampling, in each of some parts of the run.

    By a straight line; no part shares a configuration with another. Their spread is taken as that
    of all r_s: that of one is known from few.
    """
    if len(blocks) < PARTS * LEAST:
        return [np.nan] * PARTS
    slopes = []
    for part in np.array_split(blocks, PARTS):
        counts, distance, _ = contact_over_sampling(r, part, 1)
        slope, _ = np.polyfit(np.log10(counts), distance, 1)
        slopes.append(slope)
    return slopes


def measured(data):
    """Peaks, the core that is met, its drift, and the crystal that the text speaks of."""
    found = {"crystal_radius": Measured(1 / (2 + np.sqrt(2)), 0.0, "1 / (2 + sqrt 2)")}
    for radius in COLORS:
        at, name = at_radius(data, radius), f"{100 * radius:g}".replace(".", "")
        windows = ", ".join(f"{float(v):.3f}" for v in at.peak_by_window)
        found[f"peak_{name}"] = Measured(
            float(at.peak), float(at.peak_error),
            f"{windows} with a fit that reaches 1/2, 2/3 and 5/6 of the way to 2 r_s, 0.15 at most"
            f"; g(r) is within 1 % of its maximum {_top(at, radius)}",
        )  # fmt: skip
    for radius in (0.15, 0.2, 0.25):
        at, name = at_radius(data, radius), f"{100 * radius:.0f}"
        found[f"contact_{name}"] = Measured(
            float(at.contact) / (2 * radius), float(at.contact_error) / (2 * radius),
            f"2 r_0 = {float(at.contact):.3f}, g = 0.05 at {float(at.rise):.3f}",
            data.undecided,
        )  # fmt: skip
    for radius in (0.15, 0.25):
        at, name = at_radius(data, radius), f"{100 * radius:.0f}"
        found[f"drift_{name}"] = Measured(
            float(at.drift), float(at.drift_error),
            "straight lines in the logarithm of the number of configurations, mean of "
            f"{PARTS} parts of the run",
        )  # fmt: skip
        found[f"rest_{name}"] = Measured(
            float(at.contact) - RESTS[radius],
            np.sqrt(2) * float(at.contact_error),
            "the rest length was measured in the same way, with an error as large",
            data.undecided,
        )
    bare = at_radius(data, 0.0)
    found["contact_0"] = Measured(
        float(bare.contact), float(bare.contact_error), "", data.undecided
    )
    cores = [at_radius(data, radius) for radius in CORES]
    contacts, errors = np.array([(core.contact, core.contact_error) for core in cores], float).T
    closest = int(np.argmin(np.diff(contacts)))
    listed = ", ".join(f"{value:.3f}" for value in contacts)
    found["contact_order"] = Measured(
        np.diff(contacts)[closest], np.hypot(*errors[closest : closest + 2]),
        f"2 r_0 = {listed}", data.undecided,
    )  # fmt: skip
    others = [at_radius(data, radius) for radius in (0.0, 0.15, 0.2)]
    lowest = min(others, key=lambda at: float(at.peak))
    apart = at_radius(data, 0.25)
    found["peak_shift"] = Measured(
        float(apart.peak - lowest.peak), float(np.hypot(apart.peak_error, lowest.peak_error))
    )
    return found


def describe(data):
    """What is seen, in words."""
    peaks = ", ".join(f"{float(at.peak):.2f} for r_s {float(at.r_s):g}" for at in _each(data))
    return (
        f"(a) g(r) rises from zero near the core's edge to a first peak at {peaks}. (b) Closest "
        "contacts rise with 2 r_s; those of cores lie a little below the line 2 r_0 = 2 r_s. (c) "
        "They fall as more is sampled."
    )


def _each(data):
    return [data.sel(r_s=radius) for radius in data.r_s.values]


def draw(data):
    """g(r), the paper's axes; and closest contacts."""
    figure, (left, middle, right) = panels(3, height=2.6, width_ratios=(1.35, 1, 1))
    for at in _each(data):
        radius = float(at.r_s)
        color, label = COLORS.get(radius, ORANGE), f"$r_s$ = {radius:g}"
        reach = COVERAGE * at.g_error
        left.fill_between(data.r, at.g - reach, at.g + reach, color=color, alpha=0.3, linewidth=0)
        left.plot(data.r, at.g, color=color, label=label)
        middle.errorbar(
            2 * radius, at.contact, COVERAGE * at.contact_error, fmt="o", color=color, capsize=2
        )
        points(right, at.samples, at.contact_over_sampling, at.contact_over_sampling_error, None,
               color, linestyle="-")  # fmt: skip
        points(
            right, 1.3 * at.samples[-1:], [at.rise], [at.rise_error], None, color, "s", filled=False
        )
    for name, label in (("peak_0", "published"), ("peak_25", None)):
        left.axvline(PUBLISHED[name].value, color=BLACK, linestyle=":", linewidth=0.9, label=label)
    left.set(xlim=(0, 2), ylim=(0, None), xlabel="distance r / $r_c$", ylabel="g(r)")
    left.legend(loc="upper right")
    middle.plot([0, 0.65], [0, 0.65], color=BLACK, linewidth=0.8)
    middle.set(xlim=(-0.03, 0.65), ylim=(0, 0.65), xlabel="preset diameter $2 r_s$ / $r_c$",
               ylabel="closest contact $2 r_0$ / $r_c$")  # fmt: skip
    for marker, face, label in (
        ("o", "0.5", "mean over parts"), ("o", "white", "one part alone"),
        ("s", "white", "where g = 0.05"),
    ):  # fmt: skip
        right.plot([], [], marker, color="0.5", markerfacecolor=face, label=label)
    right.legend(loc="upper center")
    ends = 0.5 * float(data.samples.min()), 2 * float(data.samples.max())
    right.set(xscale="log", xlim=ends, ylim=(-0.06, 0.85), xlabel="bead-samples in g(r)",
              ylabel="first bin not empty / $r_c$")  # fmt: skip
    right.xaxis.set_minor_formatter(mpl.ticker.NullFormatter())
    return figure


def contact_over_sampling(
    r: np.ndarray, blocks: np.ndarray, samples: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """How the distance of closest contact falls as more is sampled.

    ``r``: (bins,) array. ``blocks``: (n, bins) array; g(r) in blocks. ``samples``: bead-samples in
    one block. Result: (m,) array; bead-samples: one block, two, four, and so on as long as there
    are so many. (m,) array; `contact` of so many blocks, mean over all that there are without
    overlap. (m,) array; its standard error; NaN where there is only one, or few that are
    correlated.
    """
    counts, means, errors = [], [], []
    size = 1
    while size <= len(blocks):
        together = len(blocks) // size
        parts = blocks[: together * size].reshape(together, size, -1).mean(axis=1)
        found = np.array([contact(r, part) for part in parts])
        counts.append(size * samples)
        mean, error = block_mean_and_error(found)
        means.append(float(mean))
        errors.append(float(error))
        size *= 2
    return np.array(counts), np.array(means), np.array(errors)
