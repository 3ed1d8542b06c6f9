"""What figures of Nikunen et al. 2007 share."""

import numpy as np

from dpd.analysis.statistics import block_mean_and_error, jackknife
from dpd.analysis.structure import blocks_of, on_flank, rise
from dpd.report.style import BLACK, BLUE, GREEN, ORANGE, RED

# Parameter sets, named after their repulsion a; the spring constant k is 2 a. Their colours.
SETS = {"a25": BLACK, "a50": BLUE, "a100": GREEN, "a150": ORANGE, "a200": RED}
MAIN = "a100"  # the set whose dynamics the paper shows
CONTROL = "a25"  # a set of ours, whose bonds pass through each other
PAPER_LENGTH, PAPER_CHAINS = 256, 128  # beads of a chain, chains in the box
LABELS = {
    "r_min": r"$r_{min}$",
    "l_max": r"$l_{max}$",
    "mean_bond": r"$\langle l \rangle$",
    "rms": "rms",
}


def in_words(name):
    """A set as captions and tables have it: ``a 100``."""
    return f"a {repulsion(name)}"


def repulsion(name):
    """The repulsion a that a set is named after."""
    return int(str(name).removeprefix("a"))


def law(published):
    """Exponent of a law that the paper names: the middle of what is nearer to it than to others."""
    return (published.low + published.high) / 2


def criterion(at):
    """r_min and l_max of the paper's Eq. 5, each with its standard error.

    ``at``: one point of a collected sweep with ``rdf`` and ``bonds``. Result: (r_min, error),
    (l_max, error); in r_c, by leaving out blocks.
    """
    r, length = at.r.values, at.bond_length.values
    return (
        jackknife(blocks_of(at.rdf), lambda mean: rise(r, mean)),
        jackknife(blocks_of(at.bond_density), lambda mean: fall(length, mean)),
    )


def fall(length, density, level=0.05):
    """Length at which a density last falls to a level; NaN where it does not within the bins."""
    last = int(np.flatnonzero(density >= level)[-1])
    return np.nan if last + 1 == len(density) else on_flank(length, density, last, last + 1, level)


def bond_statistics(at):
    """(mean, error) of the bond length and of the rms deviation of bonds, in r_c, by blocking.

    ``at``: one point of a collected sweep with ``bonds``.
    """
    spread = np.sqrt(blocks_of(at.bond_mean_square - at.bond_mean**2))
    return block_mean_and_error(blocks_of(at.bond_mean)), block_mean_and_error(spread)
