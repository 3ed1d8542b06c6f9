"""How chains grow from monomers, and what spare monomers are for."""

from itertools import product

import pandas as pd

from dpd.report.style import BLACK, panels
from paper_figures.liu_2008.shared import LENGTHS

TITLE = "Growth of melts of set (1) from monomers, for several N and shares of spare monomers."
PAPER_SHOWS = (
    "Not a figure of the paper, which prints no yield. Chains that are whole over those wanted: "
    "with the spare monomers that our melts have, a fifth of those needed (solid), and without any "
    "(dashed). Where a line falls, chains were cut back as bonds had crossed. Table: where beads "
    "are at the end, before all that is in no whole chain is removed. Growth ends when all chains "
    "are whole, or at the last time shown. None cross then, by construction: of two that do the "
    "younger is undone. Times in DPD units tau_0."
)
ERRORS = "One melt each, without error bars."


def compute(sweeps):
    """What was calculated."""
    return sweeps["growth"]


def table(data):
    """Where monomers are at the end."""
    rows = []
    for length, spare in product(data.length.values, data.spare.values):
        at = data.sel(length=length, spare=spare)
        free = 1 - at.in_whole - at.in_parts
        shares = (at.at_end, at.in_whole, at.in_parts, free, at.undone)
        shown = (f"{100 * float(share):.1f}" for share in shares)
        rows.append((length, f"{spare:g}", int(at.chains), f"{float(at.ended):.1f}", *shown))
    names = ("N", "spare", "chains", "end / tau_0", "whole / %", "monomers in whole chains / %",
             "in others / %", "free / %", "bonds undone / %")  # fmt: skip
    return pd.DataFrame(rows, columns=names)


def describe(data):
    """What is seen, in words."""
    bare = zip(data.length.values, data.at_end.isel(spare=0).values)
    shares = ", ".join(f"{100 * share:.0f} % at N {length}" for length, share in bare)
    return f"Chains that are whole at the end without spare monomers: {shares}."


def draw(data):
    """Whole chains over time."""
    figure, course = panels()
    for length in data.length.values:
        color = LENGTHS.get(int(length), BLACK)
        for spare, style, label in ((-1, "-", f"N = {length}"), (0, "--", None)):
            whole = data.whole.sel(length=length).isel(spare=spare)
            course.plot(data.time, whole, style, color=color, label=label)
    course.set(xlabel=r"time in growth / $\tau_0$", ylabel="whole chains / chains wanted",
               ylim=(-0.03, 1.03), xlim=(0, None))  # fmt: skip
    course.legend(loc="lower right")
    return figure
