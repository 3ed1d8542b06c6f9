"""Run time against error of every scheme: a melt of stiff bonds."""

from dpd.report.accuracy import against_time, draw, table

TITLE = "Run time against error: a melt of stiff bonds (rho 1, a 100, k 200)."
PAPER_SHOWS = (
    "Each scheme at eight time steps, at two frictions. Down: less error; left: less run time, per "
    "tau of 8192 beads on one core. Temperatures are held against kT = 1, other quantities "
    "against their limit for dt to 0 (written in), taken from Shardlow's scheme and ABOBA. "
    "Lowe-Andersen has another dynamics by design, so its diffusion has another limit. Hollow: an "
    "error that noise hides, drawn where it is below with 97.5 % confidence. Grey: the front, on "
    "which no scheme is both faster and surely more accurate. Runs that blew up, or with kT above "
    "2, are left out."
)

__all__ = ["PAPER_SHOWS", "TITLE", "compute", "draw", "measured", "table"]


def compute(data):
    """Errors and run times."""
    return against_time(data["melt"], data["schemes"], "W2")


def measured(data):
    """None: nobody has published its numbers at this length of chains."""
    return {}
