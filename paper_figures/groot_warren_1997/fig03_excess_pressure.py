"""Figure 3: excess pressure against density with a parabola."""

from dpd.analysis.pressure import excess_pressure
from dpd.report.style import BLUE, GREEN, RED, np, panels, points, published_line

TITLE = "Excess pressure against density."
PAPER_SHOWS = (
    "The paper shows p - rho kT against rho for a = 15 (crosses), 25 (squares) and 30 (circles) "
    "with a parabola through the points. Dashed: the published parabola, alpha a rho^2 with "
    "alpha = 0.101. Numbers from these runs are judged with Figure 4."
)
STYLES = {15.0: (BLUE, "X"), 25.0: (GREEN, "s"), 30.0: (RED, "o")}
ALPHA = 0.101


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
        "larger a. The points lie on the dashed published curves, slightly below them at low "
        "density."
    )


def draw(data):
    """Excess pressure, the paper's axes."""
    figure, axes = panels(1)
    rho = np.linspace(0, float(data.density.max()) * 1.03, 200)
    for a in data.repulsion.values:
        color, marker = STYLES.get(float(a), (BLUE, "D"))
        at = data.sel(repulsion=a)
        points(axes, at.density, at.excess, at.excess_error, f"$a$ = {a:g}", color, marker)
        most = float(at.excess.dropna("density").density.max())
        label = r"published $0.101\, a \rho^2$" if a == data.repulsion.values[0] else None
        published_line(axes, rho[rho <= most], ALPHA * a * rho[rho <= most] ** 2, label)
    axes.set(xlim=(0, rho[-1]), ylim=(0, None), xlabel=r"density $\rho$ $r_c^3$",
             ylabel=r"excess pressure $(p - \rho k_BT)$ / ($k_BT$ $r_c^{-3}$)")  # fmt: skip
    axes.legend(loc="upper left")
    return figure
