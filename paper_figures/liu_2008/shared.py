"""What figures of Liu et al. 2008 share."""

from typing import NamedTuple

import numpy as np

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import NONE_SEEN, block_mean_and_error, over_replicas
from dpd.analysis.structure import blocks_of, contacts
from dpd.report.style import BLACK, BLUE, GREEN, PURPLE, RED

CORES = {0.0: BLACK, 0.15: BLUE, 0.2: GREEN, 0.25: RED}  # colour of each r_s that the paper shows
LENGTHS = {20: BLUE, 50: GREEN, 100: RED, 200: PURPLE}  # colour of each chain length N
SETS = {"set_1": "set (1)", "set_2": "set (2)"}
PAPER_LENGTH = 100  # beads of the paper's chains
PAPER_BEADS = 20_000
PAPER_STEP = 0.002  # time step in tau
PAPER_TIME, PAPER_BOX = 1e4, 100.0  # of the displacements: tau, and edge in r_c
ROUSE, SEMENOV_JOHNER = 1 / 2, 8 / 15  # exponents of g_i in theory: ideal chains; compact ones
CONFIDENT = 3.0  # standard errors at which an exponent excludes another, 99.7 %


def at_radius(data, radius):
    """What was found for a core radius r_s; missing values if the study has none of it."""
    here = np.isclose(data.r_s, radius)
    return data.isel(r_s=int(np.argmax(here))) if here.any() else data.isel(r_s=0) * np.nan


def printed_share(logarithm):
    """A share as the text prints it, with one digit, from its logarithm in published.yaml."""
    return float(f"{10**logarithm:.0e}")


def share_of_long_bonds(at):
    """Share of bonds longer than 4 r_0, which is twice their rest length.

    ``at``: one point of a collected sweep with ``bonds``. Returns ``share``, ``error``: the
    standard error is from blocks of the run.
    """
    length = at.bond_length.values
    beyond = length > 2 * first_scene(at).data["bond"]["length"]
    share = blocks_of(at.bond_density)[:, beyond].sum(axis=1) * (length[1] - length[0])
    return block_mean_and_error(share)


def bonds_and_crossings(at):
    """Bonds, crossings and kT of one point of a collected sweep of melts."""
    scene = first_scene(at)
    share, share_error = share_of_long_bonds(at)
    longest, longest_error = block_mean_and_error(blocks_of(at.bond_longest))
    squares = (at.bond_mean_square - at.bond_mean**2).values.ravel()
    variance, variance_error = block_mean_and_error(squares)
    bonds = float(at.beads.sum()) * (1 - 1 / len(scene.molecules[0].beads))
    looks = scene.steps.sample // scene.observe["bonds"].every
    kT, kT_error = over_replicas(at.kT.values, at.kT_error.values, -1)
    return {
        "longest": float(longest), "longest_error": float(longest_error),
        "variance": float(variance), "variance_error": float(variance_error),
        "share": float(share), "share_error": float(share_error),
        "share_bound": NONE_SEEN / (bonds * looks), "begun": float(at.crossings_begun.sum()),
        "exposure": bonds * float(at.crossing_time.isel(replica=0).max()),
        "melt_kT": float(kT), "melt_kT_error": float(kT_error),
        "rest": scene.data["bond"]["length"],
    }  # fmt: skip


class Contact(NamedTuple):
    """The distance of closest contact 2 r_0, its standard error, and why it is none, if so."""

    value: float
    error: float
    undecided: str


def closest_contact(at):
    """How close beads come in one configuration: median of `contacts`, as of grouped data.

    Within a bin, distances are taken as uniform. The error is that of a mean of normal values times
    sqrt(pi / 2), and of counts if all lie in one bin.
    """
    found, width = contacts(at), float(at.r[1] - at.r[0])
    _, of_mean = block_mean_and_error(found)
    error = np.hypot(np.sqrt(np.pi / 2) * of_mean, width / np.sqrt(4 * len(found)))
    middle = np.median(found)
    below, inside = np.mean(found < middle - width / 4), np.mean(abs(found - middle) < width / 4)
    # No value is inside where the median of an even number lies between two bins.
    value = middle + width * ((0.5 - below) / inside - 0.5) if inside else middle
    beads, undecided = int(at.beads.max()), ""
    if beads != PAPER_BEADS:
        undecided = f"2 r_0 is of {PAPER_BEADS} beads, these runs have {beads}"
    return Contact(float(value), float(error), undecided)


def excluded(value, error):
    """What an exponent says of the two theories, in words."""
    if not np.isfinite(value):
        return "no exponent: fewer than four lags in the window"
    if not np.isfinite(error):
        return "no error: the run is too short for one"
    parts = []
    for name, theory in (("8/15", SEMENOV_JOHNER), ("1/2", ROUSE)):
        apart = (value - theory) / error
        word = "excludes" if abs(apart) > CONFIDENT else "leaves"
        parts.append(f"{word} {name} ({apart:+.1f} standard errors)")
    return ", ".join(parts)


def too_small(at):
    """Why a run cannot say what the paper's longer one in a larger box shows; empty if it can.

    ``at``: one point from `dpd.analysis.diffusion.subdiffusion`.
    """
    # A run that is a whole number of steps long may lack a rounding error.
    least = 1 - 1e-9
    if float(at.duration) >= PAPER_TIME * least and float(at.box_edge) >= PAPER_BOX * least:
        return ""
    return (
        f"the claim is on {PAPER_TIME:.0e} DPD time units in a box of {PAPER_BOX:g}, this run has "
        f"{float(at.duration):.3g} in {float(at.box_edge):g}"
    )


def samples_of(runs, observable):
    """Bead-samples that an observable of one point has taken, all replicas together."""
    scene = first_scene(runs)
    configurations = scene.steps.sample // scene.observe[observable].every
    return scene.beads * configurations * runs.scene.size
