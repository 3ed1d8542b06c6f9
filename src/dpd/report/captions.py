"""A figure's caption as HTML: number, what the paper shows, a line a sweep, errors."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from itertools import combinations_with_replacement
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from dpd.laws import numbers_of
from dpd.page import is_table
from dpd.report.notation import typeset
from dpd.scene.scene import Scene

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from types import ModuleType

    import numpy.typing as npt
    import xarray as xr

ERRORS = (
    "Error bars: 95 % intervals, 1.96 standard errors. Those of series take the integrated "
    "autocorrelation time into account, those of profiles come from blocks of the run, and both "
    "are carried through to what is derived from them. They are widened by Student's t where few "
    "independent samples have fixed them. Hollow, without a bar: the run is too short for an "
    "error (fewer than about 20 correlation times). In legends, ± of this work is a 95 % interval, "
    "too; that of a published value is as printed."
)
UNITS = (
    "Units: length r_c, energy kT, time r_c sqrt(m/kT). Settings and noise seed of each run: "
    "variables `scene` and `seed` of `sweeps/NAME.nc`, NAME being that of the sweep."
)
NUMBERED = re.compile(r"fig0*(\d+)_")
PREDICTING = ("gw-vv", "verlet-no-acceleration")  # the schemes that have a lambda to choose
NARROW_SPACE = "\N{NARROW NO-BREAK SPACE}"


@dataclass(frozen=True)
class SweepLine:
    """What a caption says of a sweep: phrases in plain notation, empty if there is nothing to say.

    Attributes
    ----------
    system : str
        Beads, molecules, box, density.
    forces : str
        Repulsion, core, bonds, angles, masses, walls, body force.
    dynamics : str
        Thermostat, scheme, time step.
    sampling : str
        Steps, equilibration, replicas.
    swept : str
        Axes whose values the others do not show.
    """

    system: str
    forces: str
    dynamics: str
    sampling: str
    swept: str

    def __str__(self):
        phrases = (self.system, self.forces, self.dynamics, self.sampling, self.swept)
        return "; ".join(phrase for phrase in phrases if phrase) + "."


def label(figure: str) -> str:
    """What a figure is called: ``Figure 4``, the paper's number, or its own name."""
    numbered = NUMBERED.match(figure)
    return f"Figure {numbered[1]}" if numbered else f"Own figure: {figure.replace('_', ' ')}"


def caption(
    figure: str, module: ModuleType, sources: Mapping[str, xr.Dataset], numbers: xr.Dataset
) -> Markup:
    """The caption of a figure.

    Parameters
    ----------
    figure : str
        Its name; ``fig04_...`` is Figure 4 of the paper, other names are figures of our own.
    module : module
        The file of the figure.
    sources : dict of str to xarray.Dataset
        Sweeps and measurements that it was made from.
    numbers : xarray.Dataset
        What is plotted.

    Returns
    -------
    markupsafe.Markup
        A fragment of HTML: paragraphs, warnings, and the figure's table, if it has one.
    """
    whose = f"{label(figure)} of the paper" if NUMBERED.match(figure) else "Our own figure"
    head = Markup("<strong>{}. {}</strong> {}").format(
        whose, typeset(module.TITLE), typeset(module.PAPER_SHOWS)
    )
    parts = [head]
    parts += [_source_line(name, source) for name, source in sources.items()]
    if any("scene" in source for source in sources.values()):
        parts.append(typeset(UNITS))
    parts.append(typeset(getattr(module, "ERRORS", ERRORS)))
    warned = list(module.warnings(numbers)) if hasattr(module, "warnings") else []
    if not getattr(module, "SHOWS_TEMPERATURE", False):
        warned += run_warnings(sources)
    parts += [Markup("<strong>Warning.</strong> {}").format(typeset(said)) for said in warned]
    body = Markup("\n").join(Markup("<p>{}</p>").format(part) for part in parts)
    if hasattr(module, "table"):
        body += Markup("\n") + _table(module.table(numbers), "Numbers of this figure")
    return body + Markup("\n")


def run_warnings(sources: Mapping[str, xr.Dataset]) -> Iterator[str]:
    """What runs have warned of, as of a kT that is not right: a sentence for each sweep.

    A figure that shows just that, kT over the time step, says so with ``SHOWS_TEMPERATURE``.
    """
    for name, source in sources.items():
        texts = (
            [str(text) for text in source["warning"].values.ravel()] if "warning" in source else []
        )
        said = [text for text in texts if text]
        if said:
            yield f"{len(said)} of {len(texts)} runs of {name} warn; the first: {said[0]}."


def _source_line(name, source):
    """One paragraph on a sweep or a measurement."""
    said = source.attrs.get("description") or str(sweep_line(source))
    return Markup("<em>{}</em>: {}").format(name, typeset(said))


def _table(frame, title):
    """A data frame of text as an HTML table."""
    cell = '<td data-label="{}">{}</td>'
    head = Markup("").join(
        Markup('<th scope="col">{}</th>').format(typeset(name)) for name in frame.columns
    )
    rows = Markup("\n").join(
        Markup("<tr>{}</tr>").format(
            Markup("").join(
                Markup(cell).format(name, typeset(value)) for name, value in zip(frame, row)
            )
        )
        for row in frame.values
    )
    return Markup(
        '<table class="cards"><caption>{}</caption>\n<thead><tr>{}</tr></thead>\n'
        "<tbody>\n{}\n</tbody></table>"
    ).format(typeset(title), head, rows)


def sweep_line(sweep: xr.Dataset) -> SweepLine:
    """What a caption says of a collected sweep.

    A quantity that differs among the runs is given as a range with the number of its values.

    Parameters
    ----------
    sweep : xarray.Dataset
        As `dpd.analysis.collect.collect` makes it.

    Returns
    -------
    SweepLine
    """
    texts = dict.fromkeys(map(str, sweep.scene.values.ravel()))
    scenes = [Scene.of_result(text, "sweep") for text in texts]
    line = SweepLine(
        _system(scenes), _forces(scenes), _dynamics(scenes), _sampling(scenes, sweep), ""
    )
    axes = [sweep[name] for name in sweep.kT.dims if name != "replica"]
    swept = ", ".join(_axis(axis) for axis in axes if not _shows(str(line), span(axis.values)))
    return replace(line, swept=f"swept: {swept}" if swept else "")


def _shows(text, values):
    """Whether values stand in a text, not as a part of others."""
    return re.search(rf"(?<![\w.]){re.escape(values)}(?![\w.])", text)


def _axis(axis):
    """Name, values and units of a swept parameter."""
    units = axis.attrs.get("units", "1")
    name = axis.attrs.get("long_name", axis.name.replace("_", " "))
    return f"{name} {span(axis.values)}" + (f" {units}" if units != "1" else "")


def span(values: npt.ArrayLike, counted: bool = True) -> str:
    """Values as text: all names, one or two numbers, or the range of more.

    Parameters
    ----------
    values : array_like of number or str
    counted : bool
        Whether a range says how many values it has.
    """
    values = list(dict.fromkeys(np.ravel(values).tolist()))
    if any(isinstance(value, str) for value in values):
        return ", ".join(str(value).replace("_", " ") for value in values)
    numbers = [_number(value) for value in sorted(values)]
    if len(numbers) < 3:
        return " and ".join(numbers)
    return f"{numbers[0]} to {numbers[-1]}" + (f" ({len(numbers)} values)" if counted else "")


def _number(value):
    """Whole numbers in groups of three digits, others to four digits."""
    if value == int(value) and abs(value) < 1e9:
        return f"{int(value):,}".replace(",", NARROW_SPACE) if abs(value) >= 1e4 else f"{value:g}"
    return f"{value:.4g}"


def _system(scenes):
    """Beads, molecules, box, density."""
    beads = span([scene.beads for scene in scenes], counted=False)
    density = span([round(scene.density, 2) for scene in scenes])
    return f"{beads} beads, {_molecules(scenes)}, {_box(scenes)}, rho = {density}{_missed(scenes)}"


def _missed(scenes):
    """What whole molecules make of a density that they cannot meet; of the worst scene."""
    missed = [pair for scene in scenes for pair in scene.missed_densities.values()]
    if not missed:
        return ""
    asked, found = max(missed, key=lambda pair: abs(pair[1] / pair[0] - 1))
    most = "at worst " if len(scenes) > 1 else ""
    return f" ({most}density {found:.4g} of whole molecules in place of {asked:g})"


def _molecules(scenes):
    """Monomers, chains of a length, or architectures."""
    kinds = {(kind.beads, kind.parents): given["architecture"] for scene in scenes
             for kind, given in zip(scene.molecules, scene.data["molecules"])}  # fmt: skip
    species = sorted({name for beads, _ in kinds for name in beads})
    of = f" of {' and '.join(species)}" if len(species) > 1 else ""
    branched = any(not kind.is_linear for scene in scenes for kind in scene.molecules)
    if branched or any(len(set(beads)) > 1 for beads, _ in kinds):
        return f"molecules {', '.join(kinds.values())}"
    lengths = [len(beads) for beads, _ in kinds]
    return f"monomers{of}" if set(lengths) == {1} else f"chains{of}, N = {span(lengths)}"


def _box(scenes):
    """Edges of one box, or the range of the edge of several."""
    boxes = list(dict.fromkeys(scene.box for scene in scenes))
    dimension = len(boxes[0])
    if len(boxes) > 1 and all(len(set(box)) == 1 for box in boxes):
        shape = "cubic" if dimension == 3 else "square"
        return f"{shape} boxes with edges of {span([box[0] for box in boxes])} r_c"
    edges = [" x ".join(f"{edge:g}" for edge in box) for box in boxes]
    return f"{'box' if len(boxes) == 1 else 'boxes'} {', '.join(edges)} r_c^{dimension}"


def _forces(scenes):
    """Repulsion, core, many-body forces, bonds, angles, masses, walls, body force, pressure."""
    terms = (
        _repulsion, _core, _many_body, _bond, _angle, _masses, _walls, _body_force, _pressure,
    )  # fmt: skip
    parts = (part(scenes) for part in terms)
    return "; ".join(part for part in parts if part)


def _repulsion(scenes):
    """a_AA = a_BB = 25, a_AB = 37: pairs of species with the same values together."""
    return f"{_by_pairs('a', scenes[0].species, [scene.repulsion for scene in scenes])} kT/r_c"


def _by_pairs(symbol, species, tables):
    """A quantity of pairs of species."""
    alike = {}
    for i, j in combinations_with_replacement(range(len(species)), 2):
        pair = _of_species(symbol, species[i], species[j])
        alike.setdefault(span([table[i, j] for table in tables]), []).append(pair)
    return ", ".join(f"{' = '.join(pairs)} = {values}" for values, pairs in alike.items())


def _of_species(symbol, *names):
    """a_AB, or a_(W1 tail) where names are longer."""
    short = "".join(names)
    return f"{symbol}_{short}" if len(short) == len(names) else f"{symbol}_({' '.join(names)})"


def _by_species(symbol, species, tables):
    """A quantity of species."""
    values = (span([table[i] for table in tables]) for i in range(len(species)))
    named = (_of_species(symbol, name) for name in species)
    return ", ".join(f"{name} = {value}" for name, value in zip(named, values))


def _masses(scenes):
    """m_A = 1, m_B = 2; nothing if no scene names masses."""
    if all(scene.masses is None for scene in scenes):
        return ""
    species = scenes[0].species
    tables = [[1] * len(species) if scene.masses is None else scene.masses for scene in scenes]
    return f"masses {_by_species('m', species, tables)}"


def _core(scenes):
    cores = [scene.data.get("core", {"radius": 0, "force": 0, "smooth": 0}) for scene in scenes]
    if not any(core["radius"] for core in cores):
        return ""
    radius = span([core["radius"] for core in cores])
    force = span([core["force"] for core in cores if core["radius"]])
    said = f"rigid core r_s = {radius} r_c, F_max = {force} kT/r_c"
    if any(core["smooth"] for core in cores):
        said += f", its edge {span([core['smooth'] for core in cores])} r_c wide"
    return said


def _many_body(scenes):
    """many-body forces of B = 25, r_d = 0.75 r_c."""
    laws = [scene.terms["many_body"] for scene in scenes if "many_body" in scene.terms]
    if not laws:
        return ""
    repulsion, range = (span([getattr(law, key) for law in laws]) for key in ("repulsion", "range"))
    return f"many-body forces of B = {repulsion}, r_d = {range} r_c"


def _bond(scenes):
    """Bonds of a kind with their numbers, kind after kind."""
    found: dict[str, list] = {}
    pages = {}
    for scene in scenes:
        if (page := scene.bond_force) is not None:
            pages[page.key] = page
            found.setdefault(page.key, []).extend(map(numbers_of, page.laws(scene).values()))
    said = []
    for key, laws in found.items():
        numbers = {name: span([law[name] for law in laws]) for name in laws[0]}
        plain = f"{key} bonds: " + ", ".join(f"{name} {{{name}}}" for name in numbers)
        said.append((pages[key].caption or plain).format(**numbers))
    return "; ".join(said)


def _angle(scenes):
    pages = [scene.terms["angle"].plain() for scene in scenes if "angle" in scene.terms]
    laws = [law for page in pages for law in (page.values() if is_table(page) else [page])]
    if not laws:
        return ""
    stiffness, angle = (span([law[key] for law in laws]) for key in ("stiffness", "angle"))
    return f"angles of stiffness k = {stiffness} kT/rad^2, at rest at {angle} degrees"


def _walls(scenes):
    """walls along z of repulsion a_w = 25: species with the same values together."""
    walls = [scene.terms["walls"] for scene in scenes if "walls" in scene.terms]
    if not walls:
        return ""
    axes = span([" and ".join("xyz"[axis] for axis in each.axes()) for each in walls])
    repulsion = span([value for each in walls for value in _all(each.repulsion)])
    gamma = span([each.gamma for each in walls], counted=False)
    rough = "smooth" if gamma == "0" else f"friction gamma = {gamma}"
    return f"walls along {axes}, a_w = {repulsion} kT/r_c, {rough}"


def _all(given):
    """Values of all species."""
    return given.values() if isinstance(given, dict) else [given]


def _body_force(scenes):
    """body force of 0.02 along x, turned round across z."""
    bodies = [scene.terms["body_force"] for scene in scenes if "body_force" in scene.terms]
    if not bodies:
        return ""
    strength = span([value for each in bodies for value in _all(each.strength)])
    axes = span([each.axis for each in bodies])
    across = [each.opposite for each in bodies if each.opposite]
    turned = f", turned round across {span(across)}" if across else ""
    return f"body force of {strength} kT/r_c along {axes}{turned}"


def _pressure(scenes):
    """constant pressure 23.7 kT/r_c^3, along z alone."""
    held = [scene.data["pressure"] for scene in scenes if "pressure" in scene.data]
    if not held:
        return ""
    alone = span(sorted({law["axes"] for law in held}))
    along = "" if alone == "all" else f", stretched along {alone}"
    target = span([law["target"] for law in held])
    return f"constant pressure {target} kT/r_c^{scenes[0].dimension}{along}"


def _dynamics(scenes):
    """Thermostat, scheme, time step."""
    integrators = [scene.data["integrator"] for scene in scenes]
    scheme = span([integrator["scheme"] for integrator in integrators])
    predicting = [each["lambda"] for each in integrators if each["scheme"] in PREDICTING]
    prediction = f", lambda = {span(predicting)}" if predicting else ""
    dt = span([integrator["dt"] for integrator in integrators])
    return f"{_thermostat(scenes)}, scheme {scheme}{prediction}, dt = {dt}"


def _thermostat(scenes):
    """sigma^2 = 2 gamma kT; distribution of the noise."""
    thermostats = [scene.data["thermostat"] for scene in scenes]
    bath = "Langevin thermostat, " if thermostats[0]["kind"] == "langevin" else ""
    noise = span([each["noise"] for each in thermostats])
    frictions = [scene.friction for scene in scenes]
    if any(np.ndim(friction) for friction in frictions):
        names, size = scenes[0].species, len(scenes[0].species)
        several = _by_species if bath else _by_pairs
        tables = [np.broadcast_to(friction, [size] * (1 if bath else 2)) for friction in frictions]
        return f"{bath}{several('gamma', names, tables)}, {noise} noise"
    gamma = span([each["gamma"] for each in thermostats], counted=False)
    if gamma == "0":
        return "no thermostat"
    sigma = span([round((2 * each["gamma"] * each["kT"]) ** 0.5, 3) for each in thermostats])
    return f"{bath}sigma = {sigma} (gamma = {gamma}), {noise} noise"


def _sampling(scenes, sweep):
    """Steps, equilibration, replicas."""
    equilibration = span([scene.steps.equilibrate for scene in scenes], counted=False)
    sampled = span([scene.steps.sample for scene in scenes], counted=False)
    replicas = sweep.sizes["replica"]
    each = f"{replicas} replicas of each run" if replicas > 1 else "one replica"
    before = "without" if equilibration == "0" else f"after {equilibration} of"
    return f"{sampled} steps {before} equilibration, {each}"
