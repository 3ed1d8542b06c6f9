"""Run time against error of every scheme: the standard fluid."""

from dpd.analysis.verdicts import Measured
from paper_figures.benchmark.shared import against_time, describe, draw, shows, table

SHOWS_TEMPERATURE = True

TITLE = "Run time against error: the standard fluid (rho 3, a 25)."
PAPER_SHOWS = shows("24 000")

__all__ = ["PAPER_SHOWS", "TITLE", "compute", "describe", "draw", "measured", "table"]


def compute(data):
    """Errors and run times."""
    return against_time(data["fluid"], data["schemes"], "W1")


def measured(data):
    """The pressure for dt to 0, known from Monte Carlo."""
    value, error = float(data.pressure_limit), float(data.pressure_limit_error)
    return {"pressure_limit": Measured(value, error, "Shardlow and ABOBA, dt to 0")}
