"""Run time against error of every scheme: the standard fluid."""

from dpd.analysis.verdicts import Measured
from dpd.report.accuracy import against_time, draw, table

TITLE = "Run time against error: the standard fluid (rho 3, a 25)."
PAPER_SHOWS = (
    "Each scheme at nine time steps, at two frictions. Down: less error; left: less run time, per "
    "tau of 24 000 beads on one core. Temperatures are held against kT = 1, other quantities "
    "against their limit for dt to 0 (written in), taken from Shardlow's scheme and ABOBA. "
    "Lowe-Andersen has another dynamics by design, so its diffusion has another limit. Hollow: an "
    "error that noise hides, drawn where it is below with 97.5 % confidence. Grey: the front, on "
    "which no scheme is both faster and surely more accurate. Runs that blew up, or with kT above "
    "2, are left out."
)

__all__ = ["PAPER_SHOWS", "TITLE", "compute", "draw", "measured", "table"]


def compute(data):
    """Errors and run times."""
    return against_time(data["fluid"], data["schemes"], "W1")


def measured(data):
    """The pressure for dt to 0, known from Monte Carlo."""
    value, error = float(data.pressure_limit), float(data.pressure_limit_error)
    return {"pressure_limit": Measured(value, error, "Shardlow and ABOBA, dt to 0, 3000 beads")}
