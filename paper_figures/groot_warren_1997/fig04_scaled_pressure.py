"""Figure 4: excess pressure over a rho^2, with the exact limits at zero density."""

import numpy as np
import xarray as xr

from dpd.analysis.statistics import COVERAGE, block_mean_and_error, linear_fit, over_replicas
from dpd.analysis.structure import excess_pressure
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLACK, panels, points
from dpd.theory.equation_of_state import MEAN_FIELD, second_virial
from paper_figures.groot_warren_1997.excess_pressure import (
    compressibility,
    dense,
    exponent,
    from_rdf,
)
from paper_figures.groot_warren_1997.shared import (
    REPULSIONS,
    excess_by,
    look_of,
    noise_of_stress,
    put_stress_noise,
)

PUBLISHED = shown_by(__file__)
ALPHA = PUBLISHED["alpha"]
MONTE_CARLO = PUBLISHED["monte_carlo_pressure"].value  # at rho 3, a 25

TITLE = "Excess pressure divided by a rho^2, alpha = (p - rho kT) / (a rho^2)."
PAPER_SHOWS = (
    "The paper shows the excess pressure over a rho^2 for a = 15, 25 and 30, with the points at "
    f"rho = 0 from the second virial coefficient, and concludes alpha = {ALPHA} for rho > 2 "
    "(shaded). The text does not say how it was fitted; as its Figure 3 shows a parabola, alpha is "
    "fitted here by one parabola p - rho kT = alpha a rho^2 through all runs denser than 2, every "
    "point with the same weight, so that dense runs decide. Star: Monte Carlo at rho 3, a 25, "
    "without time step error. Dotted: mean field, pi / 30."
)
SWEEPS = ("equation_of_state_15", "equation_of_state_25_30")
DENSITIES_OF_LEVEL = (3.0, 8.0)  # where the text says that it begins, and the highest one


def compute(sweeps):
    """Scaled pressures, alpha, pressures at the reference point, and both virials."""
    data = excess_pressure([sweeps[name] for name in SWEEPS])
    a, rho, scaled, scaled_error = dense(data)
    fit = linear_fit([a * rho**2], scaled * a * rho**2)
    data["alpha"] = ((), fit.values[0], {"units": "r_c^4", "long_name": "fit for rho > 2"})
    data["alpha_error"] = ((), fit.errors[0], {"units": "r_c^4"})
    data["plateau"] = (
        (),
        float(scaled.mean()),
        {"units": "r_c^4", "long_name": "mean, rho > 2"},
    )
    data["plateau_spread"] = ((), float(scaled.std(ddof=1)), {"units": "r_c^4"})
    spread, spread_error = max(
        _spread(scaled[rho == r], scaled_error[rho == r]) for r in set(rho) if sum(rho == r) > 1
    )
    data["scaling_spread"] = ((), spread, {"units": "1", "long_name": "largest, rho > 2"})
    data["scaling_spread_error"] = ((), spread_error, {"units": "1"})
    b2 = [float(second_virial(value)) / value for value in data.repulsion.values]
    data["zero_density"] = ("repulsion", b2, {"units": "r_c^4", "long_name": "B2 / a, exact"})
    reference, virials = sweeps["reference_pressure"], sweeps["virials"]
    for name in ("conservative", "all"):
        p, error = excess_by(reference, name)
        data[f"reference_{name}"] = ("dt", 3 + p, {"units": "kT / r_c^3"})
        data[f"reference_{name}_error"] = ("dt", error, {"units": "kT / r_c^3"})
        p, error = excess_by(virials, name)
        data[f"virial_{name}"] = ((), 5 + float(p), {"units": "kT / r_c^3"})
        data[f"virial_{name}_error"] = ((), float(error), {"units": "kT / r_c^3"})
    # What noise and friction add, from its own series: the two virials are correlated.
    added = virials.pressure_tensor_all_series - virials.pressure_tensor_series
    added = np.trace(added.transpose("axis", "axis2", "time", "replica").values) / 3
    value, error = over_replicas(*block_mean_and_error(added, alike=True), 0)
    data["virial_added"] = ((), value, {"units": "kT / r_c^3"})
    data["virial_added_error"] = ((), error, {"units": "kT / r_c^3"})
    extra = excess_pressure([sweeps["compressibility"]])
    pressures = [part[["excess", "excess_error"]].sel(repulsion=25.0) for part in (data, extra)]
    near_water = xr.concat(pressures, "density")
    fluid, pressure = sweeps["fluid"], "kT / r_c^3"
    for name, (value, error), unit in (
        ("compressibility", compressibility(near_water, 3.0), "1"),
        ("exponent", exponent(data), "1"),
        ("from_rdf", from_rdf(fluid), pressure),
    ):
        data[name] = ((), value, {"units": unit})
        data[f"{name}_error"] = ((), error, {"units": unit, "long_name": "standard error"})
    for name in ("conservative", "all"):
        p, error = excess_by(fluid, name)
        data[f"fluid_{name}"] = ((), 3 + float(p), {"units": pressure})
        data[f"fluid_{name}_error"] = ((), float(error), {"units": pressure})
    put_stress_noise(data, sweeps["virials"], slice(None))  # each of five is as good
    return data.assign_coords(dt=reference.dt)


def _spread(values, errors):
    """Relative spread of numbers that should be one, and its standard error."""
    high, low = np.argmax(values), np.argmin(values)
    mean = values.mean()
    return (values[high] - values[low]) / mean, np.hypot(errors[high], errors[low]) / mean


def measured(data):
    """Numbers of Sec. IV."""
    alpha, error = float(data.alpha), float(data.alpha_error)
    found = {
        "alpha": Measured(
            alpha, error,
            "one parabola through all runs with rho > 2; mean of the scaled pressures there "
            f"{float(data.plateau):.4f}, their spread {float(data.plateau_spread):.4f}",
            systematic=error,  # from the scatter about the parabola, which no sampling changes
        ),
        "scaling": Measured(
            float(data.scaling_spread), float(data.scaling_spread_error),
            "largest relative spread over a",
        ),
        "linear_in_a": Measured(
            float(data.exponent), float(data.exponent_error), "a = 15, 25, 30, rho > 2",
            systematic=float(data.exponent_error),  # likewise
        ),
        "compressibility": Measured(
            float(data.compressibility), float(data.compressibility_error),
            "slope of a cubic through the pressures at a = 25 and densities within 1 of 3; "
            f"1 + 2 alpha a rho with our alpha: {1 + 150 * alpha:.2f}",
        ),
        "stress_noise": noise_of_stress(data),
        "levels_off": levelling(data),
        "routes": routes(data),
    }  # fmt: skip
    for a in REPULSIONS:
        exact = float(second_virial(a)) / a
        found[f"virial_a_{a:g}"] = Measured(exact, 0.0, "closed form")
    smallest = data.dt.values.min()
    at = data.sel(dt=smallest)
    others = ", ".join(
        f"{float(data.reference_conservative.sel(dt=dt)):.3f} at dt {dt:g}"
        for dt in data.dt.values
        if dt != smallest
    )
    found["monte_carlo_pressure"] = Measured(
        float(at.reference_conservative), float(at.reference_conservative_error),
        f"conservative virial at dt {smallest:g}; {others}",
    )  # fmt: skip
    found["virial_ratio"] = Measured(
        *(float(data[name] / data.virial_conservative)
          for name in ("virial_added", "virial_added_error")),
        f"without a wall: {float(data.virial_conservative):.2f} and {float(data.virial_all):.2f}",
    )  # fmt: skip
    return found


def levelling(data):
    """Scaled pressure at density 3 over that at the highest density, a 15; NaN where not run."""
    at = data.sel(repulsion=15.0).reindex(density=DENSITIES_OF_LEVEL)
    low, high = at.scaled.values
    parts = at.scaled_error.values / at.scaled.values
    note = f"{low:.4f} at rho 3, {high:.4f} at rho 8"
    return Measured(low / high, low / high * float(np.hypot(*parts)), note)


def routes(data):
    """Largest difference of the pressures by the three lines of Eq. 15, over the second."""
    reference = float(data.fluid_conservative)
    value = {
        "all forces": float(data.fluid_all),
        "conservative": reference,
        "g(r)": 3 + float(data.from_rdf),
    }
    error = {
        "all forces": float(data.fluid_all_error),
        "conservative": float(data.fluid_conservative_error),
        "g(r)": float(data.from_rdf_error),
    }
    high, low = max(value, key=value.get), min(value, key=value.get)
    each = ", ".join(
        f"{name}: {100 * (value[name] / reference - 1):+.2f} %" for name in ("all forces", "g(r)")
    )
    return Measured(
        (value[high] - value[low]) / reference,
        float(np.hypot(error[high], error[low])) / reference,
        f"{high} less {low}; against the conservative virial, {each}; of the same configurations, "
        "so the error is an upper bound",
    )  # fmt: skip


def describe(data):
    """What is seen."""
    return (
        "Scaled excess pressure against density: from the exact values at zero density, which "
        "differ with a, the points rise and come together at density 3. From there on they rise "
        f"more and more slowly, to {float(data.scaled.max()):.3f}, and reach the published band at "
        f"{ALPHA.value:g} at the highest densities only."
    )


def draw(data):
    """Scaled pressures, the paper's axes."""
    figure, axes = panels(1)
    for a in data.repulsion.values:
        at, look = data.sel(repulsion=a), look_of(a)
        points(axes, at.density, at.scaled, at.scaled_error, *look)
        axes.plot(0, at.zero_density, look.marker, color=look.color, clip_on=False,
                  markerfacecolor="white",
                  label=r"$B_2/a$, exact" if a == data.repulsion.values[0] else None)  # fmt: skip
    end = float(data.density.max()) * 1.03
    low, high = ALPHA.value - ALPHA.error, ALPHA.value + ALPHA.error
    axes.fill_between([2, end], low, high, color=BLACK, alpha=0.2, linewidth=0,
                      label=rf"published $\alpha$ = {ALPHA}")  # fmt: skip
    alpha, error = float(data.alpha), float(data.alpha_error)
    axes.plot([2, end], [alpha, alpha], color=BLACK, linewidth=0.9,
              label=rf"fit for $\rho$ > 2: {alpha:.4f} ± {COVERAGE * error:.4f}")  # fmt: skip
    axes.plot(
        [0, end], [MEAN_FIELD[3]] * 2, color=BLACK, linestyle=":", label=r"mean field $\pi/30$"
    )
    axes.plot(
        3,
        (MONTE_CARLO - 3) / (25 * 9),
        "*",
        color=BLACK,
        markersize=7,
        label="Monte Carlo, $a$ = 25",
    )
    axes.set(xlim=(0, end), ylim=(0.03, 0.11), xlabel=r"density $\rho$ $r_c^3$",
             ylabel=r"$(p - \rho k_BT) / (a \rho^2)$ / $r_c^4$")  # fmt: skip
    axes.legend(loc="lower right")
    return figure
