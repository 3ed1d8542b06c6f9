"""Figure 4: a window of the melt, every chain its own colour."""

import numpy as np
import xarray as xr
from matplotlib.collections import LineCollection

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import jackknife, taped
from dpd.analysis.verdicts import Measured
from dpd.observe.chains import sizes
from dpd.report.style import mpl, panels
from paper_figures.liu_2008.shared import PAPER_LENGTH

TITLE = "Snapshot of a melt of set (1)."
PAPER_SHOWS = (
    "The paper shows a 30 x 30 window of a melt of N = 100 after 1e6 steps, a colour for each "
    "chain, in which no two bonds cross, and says that chains are neither elongated nor discs, but "
    "of many shapes. Here: the last configuration of the run of that length, or of the longest "
    "chains that this study has. The shape of a chain is the elongation e = (l_1 - l_2) / (l_1 + "
    "l_2) of the two eigenvalues of its gyration tensor: 0 for a disc, 1 for a rod. How diverse "
    "the shapes are is held against ideal chains of as many beads in two dimensions."
)
ERRORS = "The window is as large as the paper's, or the whole box where that is smaller."
WINDOW = 30.0
CLOSE = 2.0  # r_c: chains that come closer are neighbours
FEWEST = 10  # chains for an error of their shapes
WALKS = 20_000  # ideal chains whose shapes are the measure


def compute(sweeps):
    """Chains in one piece, from the last configuration of the melt of the paper's length."""
    melts = sweeps["melts"]
    lengths = melts.length.values
    length = PAPER_LENGTH if PAPER_LENGTH in lengths else int(lengths.max())
    at = melts.sel(length=length).isel(replica=0)
    box = np.array(first_scene(at).box)
    beads = int(at.beads)
    place = at.position.values[:, :beads].reshape(2, -1, length)
    steps, edges = np.diff(place, axis=2), box[:, None, None]
    steps -= edges * np.round(steps / edges)  # to the nearest image of the bead before
    chains = np.concatenate([place[:, :, :1], steps], axis=2).cumsum(axis=2)
    gyration, across = sizes(chains)
    return xr.Dataset(
        {
            "position": (("axis", "chain", "bead"), chains, {"units": "r_c"}),
            "box": (("axis",), box, {"units": "r_c"}),
            "elongation": (("chain",), elongations(chains), {"units": "1"}),
            "crossings": ((), float(at.crossings.values[-1]), {"units": "1"}),
            "most_crossings": ((), float(at.crossings.max()), {"units": "1"}),
            "steps": ((), int(at.steps)),
            "gyration_square": ((), gyration, {"units": "r_c^2"}),
            "end_to_end_square": ((), across, {"units": "r_c^2"}),
        }
    )


def elongations(chains):
    """(l_1 - l_2) / (l_1 + l_2) of the eigenvalues of the gyration tensors.

    ``chains``: (2, chains, beads) array; in one piece. Result: (chains,) array; 0 for a disc, 1 for
    a rod.
    """
    apart = chains - chains.mean(axis=2, keepdims=True)
    tensor = np.einsum("acb,dcb->cad", apart, apart) / chains.shape[2]
    low, high = np.linalg.eigvalsh(tensor).T
    return (high - low) / (high + low)


def measured(data):
    """No crossing in the snapshot, and the shapes of chains."""
    size = np.sqrt(float(data.gyration_square))
    note = (
        f"{data.sizes['chain']} chains of {data.sizes['bead']} after {int(data.steps)} steps; most "
        f"at any sample of the run {float(data.most_crossings):.0f}; radius of gyration {size:.2f}"
    )
    found = {"snapshot_crossings": Measured(float(data.crossings), 0.0, note)}
    shape = data.elongation.values[:, None]
    few = len(shape) < FEWEST
    reason = f"{len(shape)} chains are too few for an error" if few else ""
    low, high = np.quantile(shape, (0.1, 0.9))
    ideal = _ideal(data.sizes["bead"])
    note = (
        f"{len(shape)} chains of one configuration, a tenth below {low:.2f} and above {high:.2f}; "
        f"ideal chains: mean {ideal.mean():.3f}, standard deviation {ideal.std():.3f}"
    )
    for name, moments in (
        ("shape", lambda m: m[0]),
        ("shape_spread", lambda m: np.sqrt(max(m[1] - m[0] ** 2, 0.0)) / ideal.std()),
    ):
        value, error = jackknife(np.hstack([shape, shape**2]), moments)
        found[name] = Measured(value, error, note, reason)
    return found


@taped
def _ideal(length):
    """Elongations of ideal chains, whose bonds point anywhere, in two dimensions."""
    steps = np.random.default_rng(1).normal(size=(2, WALKS, length))
    return elongations(steps.cumsum(axis=2))


def describe(data):
    """What is seen, in words."""
    return (
        f"A window of a melt of chains of {data.sizes['bead']} beads, each in its own colour; "
        "winding chains of all shapes fill the plane, and none crosses another."
    )


def draw(data):
    """Bonds of the chains, with their periodic images, in the window."""
    figure, axes = panels(1, height=3.4)
    chains, box = data.position.values, data.box.values
    window = min(WINDOW, box.min())
    colors = _apart(chains, box)
    for chain, color in zip(np.moveaxis(chains, 1, 0), colors):
        lines = [chain.T + shift for shift in _images(chain, box)]
        axes.add_collection(LineCollection(lines, colors=[color], linewidths=0.8))
    axes.set(
        xlim=(0, window), ylim=(0, window), xlabel="x / $r_c$", ylabel="y / $r_c$", aspect="equal"
    )
    steps = f"{int(data.steps):,}".replace(",", " ")
    axes.set_title(f"N = {data.sizes['bead']}, {steps} steps, "
                   f"{float(data.crossings):.0f} crossings in the box")  # fmt: skip
    return figure


def _apart(chains, box):
    """A colour for each chain, far in hue from those of chains that come close to it.

    Chains take the hues in turn, each the free one farthest from the hues of its neighbours.
    """
    count = chains.shape[1]
    place = np.moveaxis(chains, 0, 2)
    near = np.zeros((count, count), dtype=bool)
    for k, chain in enumerate(place):
        apart = place[:, :, None] - chain[None, None]
        apart -= box * np.round(apart / box)
        near[k] = (np.square(apart).sum(axis=3).min(axis=(1, 2))) < CLOSE**2
    hues, free = np.full(count, np.nan), list(np.arange(count) / count)
    for k in np.argsort(-near.sum(axis=1)):  # the most neighbours first
        taken = hues[near[k] & np.isfinite(hues)]
        gaps = [min(_around(hue - taken), default=1.0) for hue in free]
        hues[k] = free.pop(int(np.argmax(gaps)))
    colors = mpl.colormaps["hsv"](hues)
    colors[:, :3] *= 0.8  # darker: pure yellow does not show on white
    return colors


def _around(difference):
    """Distance of hues on their circle."""
    return np.abs(difference - np.round(difference))


def _images(chain, box):
    """Shifts by whole boxes that put a part of the chain into the box."""
    low, high = chain.min(axis=1), chain.max(axis=1)
    ranges = [
        np.arange(-np.floor(last / edge), -np.floor(first / edge) + 1) * edge
        for first, last, edge in zip(low, high, box)
    ]
    return [np.array([x, y]) for x in ranges[0] for y in ranges[1]]
