"""Figure 3: excess pressure against density with a parabola."""

import numpy as np

from dpd.analysis.structure import excess_pressure
from dpd.analysis.verdicts import shown_by
from dpd.report.style import panels, points, published_line
from paper_figures.groot_warren_1997.shared import look_of

PUBLISHED = shown_by(__file__)
ALPHA = PUBLISHED["alpha"].value
LEVEL = 3.0  # the density from which the text has the law hold

TITLE = "Excess pressure against density."
PAPER_SHOWS = (
    "The paper shows p - rho kT against rho for a = 15 (crosses), 25 (squares) and 30 (circles) "
    "with a parabola through the points. Dashed: the published parabola, alpha a rho^2 with "
    f"alpha = {ALPHA:g}. Numbers from these runs are judged with Figure 4."
)


def compute(sweeps):
    """Excess pressures over repulsion and density."""
    return excess_pressure(list(sweeps.values()))


def measured(data):
    """None here: see Figure 4."""
    return {}


def describe(data):
    """What is seen."""
    return (
        "Excess pressure against density for three repulsions: three parabolas, steeper for "
        "larger a. At the highest densities the points lie on the dashed published curves; at "
        f"density 3 they are {_below(data):.0f} % below."
    )


def _below(data):
    """How far the pressures are below the published parabola, in %, mean over a."""
    at = data.excess.sel(density=LEVEL) / (ALPHA * data.repulsion * LEVEL**2)
    return float(100 * (1 - at).mean())


def draw(data):
    """Excess pressure, the paper's axes."""
    figure, axes = panels(1)
    rho = np.linspace(0, float(data.density.max()) * 1.03, 200)
    for a in data.repulsion.values:
        at = data.sel(repulsion=a)
        points(axes, at.density, at.excess, at.excess_error, *look_of(a))
        most = float(at.density.where(at.excess.notnull()).max())
        label = rf"published ${ALPHA:g}\, a \rho^2$" if a == data.repulsion.values[0] else None
        published_line(axes, rho[rho <= most], ALPHA * a * rho[rho <= most] ** 2, label)
    axes.set(xlim=(0, rho[-1]), ylim=(0, None), xlabel=r"density $\rho$ $r_c^3$",
             ylabel=r"excess pressure $(p - \rho k_BT)$ / ($k_BT$ $r_c^{-3}$)")  # fmt: skip
    axes.legend(loc="upper left")
    return figure
