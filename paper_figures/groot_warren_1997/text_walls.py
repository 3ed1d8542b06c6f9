"""Sec. IV: the pressure between soft walls in three ways."""

import numpy as np
import xarray as xr
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from scipy.optimize import minimize_scalar

from dpd.analysis.collect import first_scene
from dpd.analysis.statistics import linear_fit, mean_and_error
from dpd.analysis.verdicts import Measured, shown_by
from dpd.report.style import BLACK, BLUE, GREEN, ORANGE, RED, Look, panels, points

PUBLISHED = shown_by(__file__)
PRINTED = {"bulk": "wall_pressure", "noisy": "wall_pressure_all", "force": "wall_force"}
ASIDE = 0.0006  # tau, by which points at the same step are drawn beside each other
PAPER_STEP = 0.04  # tau
BESIDE = 0.6  # kT / r_c, by which points at the same a_w are drawn beside each other
AWAY = 0.0025  # tau, by which published numbers stand beside ours
MIDDLE = 1.5  # r_c on either side of the middle, which is the bulk
LOOKS = {
    "bulk": Look("bulk, virial without noise", BLUE, "o"),
    "normal": Look("bulk, normal pressure", GREEN, "s"),
    "noisy": Look("bulk, virial with noise", ORANGE, "^"),
    "force": Look("force on the walls per area", RED, "D"),
}

TITLE = "Pressure between soft walls in three ways (mean rho = 5, a = 15, 8 x 5 x 5)."
PAPER_SHOWS = (
    "Not a figure of the paper: its text gives three pressures of a box with a soft wall, "
    f"{PUBLISHED['wall_pressure']} without noise, {PUBLISHED['wall_pressure_all']} with noise and "
    f"{PUBLISHED['wall_force']} from the force on the wall (bands in the colors of ours), and no "
    "form of the wall. Here walls push with a_w (1 - z) at both ends. Virials are those of the "
    "bulk; what noise adds is known for the whole box alone. (a) Pressures over a_w: a stiffer wall"
    " takes more of the volume, and the bulk is denser. Dotted: the a_w at which all three "
    "published numbers agree best. (b) For a_w = 50, over the time step, less the force on the "
    "walls: at dt 0.04, which the paper uses, forces and momenta that are taken at the end of a "
    "step do not balance exactly. Hollow: the published numbers."
)


def compute(sweeps):
    """Pressures over the strength of the walls, and over the time step at one of them."""
    strong, small = sweeps["walls"], sweeps["walls_small_step"]
    over_strength = xr.concat(
        [of_run(strong.sel(strength=a)) for a in strong.strength.values], strong.strength
    )
    steps = [of_run(small.sel(dt=dt)) for dt in small.dt.values]
    same = first_scene(small).data["walls"]["repulsion"]
    dt = [*small.dt.values.astype(float)]
    if same in strong.strength.values:
        steps.append(of_run(strong.sel(strength=same)))
        dt.append(first_scene(strong).data["integrator"]["dt"])
    over_step = xr.concat(steps, xr.DataArray(dt, dims="dt", name="dt", attrs={"units": "tau"}))
    over_step = over_step.rename({name: f"step_{name}" for name in over_step.data_vars})
    data = xr.merge([over_strength, over_step], combine_attrs="drop_conflicts")
    found, at = best_wall(over_strength)
    data["best"] = ((), found, {"units": "kT / r_c", "long_name": "a_w that fits the paper best"})
    for name, (value, error) in at.items():
        data[f"best_{name}"] = ((), value, {"units": "kT / r_c^3"})
        data[f"best_{name}_error"] = ((), error, {"units": "kT / r_c^3"})
    return data


def of_run(runs):
    """Pressures of one point, and the density of its bulk."""
    run, apart = runs.isel(replica=0), first_scene(runs).box[0]
    inner = np.abs(run.slice.values - apart / 2) < MIDDLE
    normal, tangential = (
        run[f"{name}_pressure_profile"].values[:, inner].mean(axis=1)
        for name in ("normal", "tangential")
    )
    bulk, bulk_error, _ = mean_and_error((normal + 2 * tangential) / 3)
    # What friction and noise add to the virial of the whole box.
    noise = (run.excess_all_series - run.excess_conservative_series).values
    added, added_error, _ = mean_and_error(noise)
    near = np.abs(run.z.values - apart / 2) < MIDDLE
    density = float(run.density_profile.values[:, 0, near].mean())
    parts = {
        "bulk": (bulk, bulk_error),
        "normal": mean_and_error(normal)[:2],
        "noisy": (bulk + added, np.hypot(bulk_error, added_error)),
        "force": mean_and_error(run.wall_pressure.values.mean(axis=1))[:2],
    }
    pressure = {"units": "kT / r_c^3"}
    found = {"bulk_density": ((), density, {"units": "1 / r_c^3"})}
    found["kT"] = ((), float(run.kT), {"units": "kT"})
    for name, (value, error) in parts.items():
        found[name] = ((), value, pressure | {"long_name": LOOKS[name][0]})
        found[f"{name}_error"] = ((), error, pressure | {"long_name": "standard error"})
    return xr.Dataset(found)


def best_wall(data):
    """The strength at which three pressures meet the published ones best, and these pressures.

    Each pressure is a parabola of ln a_w through the runs.

    Returns ``strength``: NaN with fewer than three strengths, or where a run is too short for an
    error. ``pressures``: value and error of each of `PRINTED`.
    """
    errors = [data[f"{name}_error"].values for name in PRINTED]
    if data.sizes["strength"] < 3 or not (np.isfinite(errors).all() and np.min(errors) > 0):
        return np.nan, dict.fromkeys(PRINTED, (np.nan, np.nan))
    x = np.log(data.strength.values.astype(float))

    def fit(name, about):
        return linear_fit([(x - about) ** k for k in range(3)], data[name].values,
                          data[f"{name}_error"].values)  # fmt: skip

    whole = {name: fit(name, x.mean()).values for name in PRINTED}

    def misfit(at):
        powers = (at - x.mean()) ** np.arange(3)
        return sum(
            ((whole[name] @ powers - PUBLISHED[row].value) / PUBLISHED[row].error) ** 2
            for name, row in PRINTED.items()
        )

    best = minimize_scalar(misfit, bounds=(x.min(), x.max()), method="bounded").x
    at = {name: fit(name, best) for name in PRINTED}
    return float(np.exp(best)), {
        name: (float(found.values[0]), float(found.errors[0])) for name, found in at.items()
    }


def measured(data):
    """The three numbers at the best wall, and how well ways to the pressure agree."""
    best, low, high = float(data.best), float(data.strength.min()), float(data.strength.max())
    outside = ""
    if not low * 1.01 < best < high * 0.99:
        outside = f"no a_w from {low:g} to {high:g} gives such pressures"
    found = {
        row: Measured(
            float(data[f"best_{name}"]), float(data[f"best_{name}_error"]),
            f"a_w {best:.1f}, where the bulk has the density "
            f"{float(np.interp(best, data.strength, data.bulk_density)):.2f}", outside,
        )
        for name, row in PRINTED.items()
    }  # fmt: skip
    ratio = data.best_force / data.best_noisy
    spread = np.hypot(data.best_force_error / data.best_force,
                      data.best_noisy_error / data.best_noisy)  # fmt: skip
    kT = float(data.kT.mean())
    found["wall_over_virial"] = Measured(
        float(ratio), float(ratio * spread), f"kT {kT:.4f} at the end of steps", outside
    )
    for name, place in (("wall_routes_step", -1), ("wall_routes", 0)):
        at = data.isel(dt=place)
        found[name] = largest_difference(at, f"dt {float(at.dt):g}")
    return found


def largest_difference(at, note):
    """Of the bulk virial, the normal pressure and the force, over the force."""
    names = ("bulk", "normal", "force")
    value = {name: float(at[f"step_{name}"]) for name in names}
    high, low = max(value, key=value.get), min(value, key=value.get)
    error = np.hypot(*(float(at[f"step_{name}_error"]) for name in (high, low)))
    each = ", ".join(f"{name} {value[name]:.2f}" for name in names)
    return Measured(
        (value[high] - value[low]) / value["force"], float(error) / value["force"],
        f"{note}; {each}",
    )  # fmt: skip


def describe(data):
    """What is seen."""
    return (
        "(a) Pressures rise with the strength of the walls and cross the bands near a_w = "
        f"{float(data.best):.0f}; that without noise is the lowest, that of the force on the walls "
        "the highest. (b) The smaller the time step, the closer the pressures come to the force "
        "on the walls."
    )


def draw(data):
    """Pressures over the strength of the walls, and differences over the time step."""
    figure, (left, right) = panels(2, height=3.1)
    for place, (name, (label, color, marker)) in enumerate(LOOKS.items()):
        aside = (place - 1.5) * BESIDE
        points(left, data.strength + aside, data[name], data[f"{name}_error"], label, color, marker)
    for name, row in PRINTED.items():
        value, error, color = PUBLISHED[row].value, PUBLISHED[row].error, LOOKS[name].color
        left.axhspan(value - error, value + error, color=color, alpha=0.3, lw=0)
    if np.isfinite(data.best):
        left.axvline(float(data.best), color=BLACK, ls=":", lw=0.8,
                     label=f"best $a_w$, {float(data.best):.1f}")  # fmt: skip
    left.set(xlabel="strength of the walls $a_w$ $r_c$ / $k_BT$",
             ylabel=r"pressure / ($k_BT$ $r_c^{-3}$)")  # fmt: skip
    for name, aside in (("bulk", -ASIDE), ("normal", 0.0), ("noisy", ASIDE)):
        _, color, marker = LOOKS[name]
        relative = 100 * (data[f"step_{name}"] / data.step_force - 1)
        error = 100 * np.hypot(data[f"step_{name}_error"] / data.step_force,
                               data.step_force_error / data.step_force)  # fmt: skip
        points(right, data.dt + aside, relative, error, None, color, marker)
        if name in PRINTED:
            printed, force = PUBLISHED[PRINTED[name]], PUBLISHED["wall_force"]
            apart = 100 * (printed.value / force.value - 1)
            spread = 100 * np.hypot(printed.error, force.error) / force.value
            right.errorbar(PAPER_STEP + AWAY + aside, apart, spread, color=color, marker=marker,
                           markerfacecolor="white", capsize=1.5)  # fmt: skip
    right.axhline(0, color=RED, lw=0.8)
    low, _ = right.get_ylim()
    right.set(xlim=(0, 0.046), ylim=(low, 0.1), xticks=[0, 0.01, 0.02, 0.03, 0.04],
              xlabel=r"time step $\Delta t$ / $\tau$",
              ylabel="pressure less force per area / %")  # fmt: skip
    handles, labels = left.get_legend_handles_labels()
    handles += [
        Patch(color=BLACK, alpha=0.3, lw=0),
        Line2D([], [], color=BLACK, ls="none", marker="o", markerfacecolor="white"),
    ]
    labels += ["published (a)", "published (b)"]
    figure.legend(handles, labels, loc="outside upper center", ncols=3)
    return figure
