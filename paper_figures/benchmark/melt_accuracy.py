"""Run time against error of every scheme: a melt of stiff bonds."""

from paper_figures.benchmark.shared import against_time, describe, draw, shows, table

SHOWS_TEMPERATURE = True

TITLE = "Run time against error: a melt of stiff bonds (rho 1, a 100, k 200)."
PAPER_SHOWS = shows("8192")

__all__ = ["PAPER_SHOWS", "TITLE", "compute", "describe", "draw", "measured", "table"]


def compute(data):
    """Errors and run times."""
    return against_time(data["melt"], data["schemes"], "W2")


def measured(data):
    """None: nobody has published its numbers at this length of chains."""
    return {}
