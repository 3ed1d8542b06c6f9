"""Numbers, names and the field's notation as text, `a_AA = 25`, `r_c^3` as HTML; captions."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import combinations_with_replacement
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from jinja2 import Environment, FileSystemLoader
from markupsafe import Markup, escape

from dpd.analysis.collect import cached_scene
from dpd.page import is_table
from dpd.scene.scene import Scene

if TYPE_CHECKING:
    import xarray as xr

NARROW_SPACE = "\N{NARROW NO-BREAK SPACE}"
NUMBERED = re.compile(r"fig0*(\d+)_")
GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "Delta": "Δ", "epsilon": "ε",
    "eta": "η", "kappa": "κ", "lambda": "λ", "mu": "μ", "nu": "ν", "xi": "ξ", "pi": "π",
    "rho": "ρ", "sigma": "σ", "tau": "τ", "phi": "φ", "chi": "χ", "omega": "ω",
}  # fmt: skip
_GREEK = "|".join(GREEK)
_NUMBER = r"[+-]?\d+(?:\.\d+)?"
# In this order, on text whose <, > and & are escaped already.
RULES: list[tuple[str, Any]] = [
    # <l^2>, an average: no space inside the brackets.
    (r"&lt;(?! )([^&]*?)(?<! )&gt;", r"⟨\1⟩"),
    # Fig. 4 stays on one line, and so does Sec. III C, whose C is no spring constant.
    (r"\b(Sec\.|Eq\.|Fig\.|Figure|Table) (?=[IVX\d])", "\\1\N{NO-BREAK SPACE}"),
    (r"\b([IVX]+) ([A-D])\b(?! =)", "\\1\N{NO-BREAK SPACE}\\2"),
    (r"&gt;=", "≥"),
    (r"&lt;=", "≤"),
    (r"\+-", "±"),
    (r"(?<=\d) x (?=\d)", " × "),
    (r" \. ", " · "),
    (r"\bsqrt\((\w+)\)", r"√\1"),
    (r"\bsqrt\(", "√("),
    # 1e6, 2.2e-7, (3.210 ± 0.045)e-6
    (r"(?<![\w.])1e([+-]?\d+)\b", lambda found: f"10^{int(found[1])}"),
    (
        r"(?<![\w.])(\d+(?:\.\d+)?|\([^()]*±[^()]*\))e([+-]?\d+)\b",
        lambda found: f"{found[1]} × 10^{int(found[2])}",
    ),
    (r"\bDelta (?=[a-z]\b)", "Δ"),
    (r"\bk_BT\b", "k_B T"),
    (r"\bkT\b", "<i>kT</i>"),
    # Subscripts and superscripts.
    (r"(?:\b|(?<=Δ))([A-Za-z])_([A-Za-z]+|\d+)(?![\w(])", r"<i>\1</i><sub>\2</sub>"),
    (rf"\b({_GREEK})_([A-Za-z]+|\d+)(?!\w)", r"\1<sub>\2</sub>"),
    (r"\b([A-Za-z])_\(([^()]*)\)", r"<i>\1</i><sub>\2</sub>"),
    (rf"\b({_GREEK})_\(([^()]*)\)", r"\1<sub>\2</sub>"),
    (r"\^\(([^()]*)\)", r"<sup>\1</sup>"),
    (rf"\^({_NUMBER}|[A-Za-z]+)", r"<sup>\1</sup>"),
    (r"(?<![\w)])-(?=\d|\w\b)| - ", lambda found: found.group().replace("-", "−")),
    (r"\bdt\b", "Δ<i>t</i>"),
    (rf"\b(d?)({_GREEK})\b", lambda found: found[1] + GREEK[found[2]]),
    # g(r), R(t): a function and its argument.
    (r"\b([A-Za-z])\(([rt0])\)", r"<i>\1</i>(<i>\2</i>)"),
    (r"<i>0</i>", "0"),
    # The letters that name a quantity wherever they stand alone; not (c), a panel.
    (r"(?<![\w.&>;\N{NO-BREAK SPACE}])([CDFLNRTgklnprtxz])\b(?!(?<=\(.)\))", r"<i>\1</i>"),
    (r"(?<![\w.&>;])([A-Zb-z])(?= [=≥≤~] )", r"<i>\1</i>"),
    # a is an article as well.
    (r"(?<!\w)a\b(?= =|<su| ?ρ| [&≥≤])|(?<=[/−] )a\b|(?<=Δ)a\b|(?<=\d )a\b(?! \w)", "<i>a</i>"),
]  # fmt: skip
PREDICTING = ("gw-vv", "verlet-no-acceleration")  # the schemes that have a lambda to choose
IF_GIVEN = re.compile(r"\[(.*?)\]")  # what a page's caption leaves out where all is as by default
SETTING = re.compile(r"\{(\w+)\}")


def typeset(text: str) -> Markup:
    """Plain notation as HTML; what stands in backticks is code and stays as it is."""
    parts = []
    for place, part in enumerate(str(text).split("`")):
        safe = str(escape(part))
        for pattern, put in RULES if place % 2 == 0 else ():
            safe = re.sub(pattern, put, safe)
        parts.append(f"<code>{safe}</code>" if place % 2 else safe)
    return Markup("".join(parts))


def label(figure: str) -> str:
    """What a figure is called: ``Figure 4``, the paper's number, or its own name."""
    numbered = NUMBERED.match(figure)
    return f"Figure {numbered[1]}" if numbered else f"Own figure: {figure.replace('_', ' ')}"


def named(paper: str) -> str:
    """groot_warren_1997 as Groot Warren 1997."""
    return paper.replace("_", " ").title()


def rendered(template: str, folder: Path = Path(__file__).parent, **values: Any) -> str:
    """A template of a folder, filled; what goes into HTML is escaped."""
    environment = Environment(
        loader=FileSystemLoader(folder), autoescape=template.endswith(".html"),
        trim_blocks=True, keep_trailing_newline=True,
    )  # fmt: skip
    environment.filters |= {"typeset": typeset, "label": label, "named": named}
    return environment.get_template(template).render(**values)


def with_error(value: float, error: float | None = None) -> str:
    """A number with as many digits as its error has meaning for: two of the error's."""
    if not np.isfinite(value):
        return "–"
    if error is None or not np.isfinite(error) or error <= 0:
        return f"{value:.4g}"
    power = int(np.floor(np.log10(max(abs(value), error))))
    if not -4 <= power < 6:
        return f"({with_error(value / 10.0**power, error / 10.0**power)})e{power}"
    digits = max(0, 1 - int(np.floor(np.log10(error))))
    return f"{value:.{digits}f} ± {error:.{digits}f}"


def whole(value: float) -> str:
    """A whole number, in groups of three digits from ten thousand on."""
    return f"{value:,.0f}".replace(",", NARROW_SPACE) if abs(value) >= 1e4 else f"{value:.0f}"


def span(values: npt.ArrayLike, counted: bool = True) -> str:
    """Values as text: all names, one or two numbers, or the range of more and their number."""
    found = list(dict.fromkeys(np.ravel(values).tolist()))
    if any(isinstance(value, str) for value in found):
        return ", ".join(str(value).replace("_", " ") for value in found)
    numbers = [
        whole(value) if value == int(value) and abs(value) < 1e9 else f"{value:.4g}"
        for value in sorted(found)
    ]
    if len(numbers) < 3:
        return " and ".join(numbers)
    return f"{numbers[0]} to {numbers[-1]}" + (f" ({len(numbers)} values)" if counted else "")


def caption(
    figure: str, module: ModuleType, sources: Mapping[str, xr.Dataset], numbers: xr.Dataset
) -> str:
    """The caption of a figure as HTML; ``sources``: sweeps and measurements that made it."""
    return rendered(
        "caption.html", module=module, numbers=numbers, sources=sources,
        whose=f"{label(figure)} of the paper" if NUMBERED.match(figure) else "Our own figure",
        sweep_line=sweep_line,
        has_runs=any("scene" in source for source in sources.values()),
    )  # fmt: skip


def sweep_line(sweep: xr.Dataset) -> str:
    """What a caption says of a sweep: system, forces, dynamics, sampling or what is calculated."""
    if key := sweep.attrs.get("calculation"):
        line = f"calculated, nothing is simulated: {key.replace('_', ' ')}"
        axes = sweep.attrs["axes"].split()
    else:
        texts = dict.fromkeys(map(str, sweep.scene.values.ravel()))
        scenes = [cached_scene(text, "sweep") for text in texts]
        line, axes = line_of(scenes, sweep.sizes["replica"]), sweep.kT.dims[:-1]
    swept = []
    for axis in (sweep[name] for name in axes):
        values, units = span(axis.values), axis.attrs.get("units", "1")
        name = axis.attrs.get("long_name", axis.name.replace("_", " "))
        # Not what the line says already, and not as a part of other values.
        if not re.search(rf"(?<![\w.]){re.escape(values)}(?![\w.])", line):
            swept.append(f"{name} {values}" + (f" {units}" if units != "1" else ""))
    return f"{line}; swept: {', '.join(swept)}." if swept else f"{line}."


def line_of(scenes: Sequence[Scene], replicas: int = 1) -> str:
    """What a caption says of some scenes."""
    equilibration = span([scene.steps.equilibrate for scene in scenes], counted=False)
    sampled = span([scene.steps.sample for scene in scenes], counted=False)
    runs = f"{replicas} replicas of each run" if replicas > 1 else "one replica"
    before = "without" if equilibration == "0" else f"after {equilibration} of"
    sampling = f"{sampled} steps {before} equilibration, {runs}"
    integrators = [scene.data["integrator"] for scene in scenes]
    scheme = span([integrator["scheme"] for integrator in integrators])
    predicting = [each["lambda"] for each in integrators if each["scheme"] in PREDICTING]
    prediction = f", lambda = {span(predicting)}" if predicting else ""
    dt = span([integrator["dt"] for integrator in integrators])
    dynamics = f"{_thermostat(scenes)}, scheme {scheme}{prediction}, dt = {dt}"
    said = (_system(scenes), *_forces(scenes), dynamics, sampling)
    return "; ".join(phrase for phrase in said if phrase)


def _system(scenes):
    """Beads, molecules, box, density."""
    beads = span([scene.beads for scene in scenes], counted=False)
    density = span([round(scene.density, 2) for scene in scenes])
    boxes = list(dict.fromkeys(scene.box for scene in scenes))
    dimension = len(boxes[0])
    if len(boxes) > 1 and all(len(set(edges)) == 1 for edges in boxes):
        shape = "cubic" if dimension == 3 else "square"
        box = f"{shape} boxes with edges of {span([edges[0] for edges in boxes])} r_c"
    else:
        each = [" x ".join(f"{edge:g}" for edge in edges) for edges in boxes]
        box = f"{'box' if len(boxes) == 1 else 'boxes'} {', '.join(each)} r_c^{dimension}"
    line = f"{beads} beads, {_molecules(scenes)}, {box}, rho = {density}"
    missed = [pair for scene in scenes for pair in scene.missed_densities.values()]
    if not missed:  # all densities are met by whole molecules
        return line
    asked, found = max(missed, key=lambda pair: abs(pair[1] / pair[0] - 1))
    most = "at worst " if len(scenes) > 1 else ""
    return f"{line} ({most}density {found:.4g} of whole molecules in place of {asked:g})"


def _molecules(scenes):
    """Monomers, chains of a length, or architectures."""
    kinds = {(kind.beads, kind.parents, kind.rings): given["architecture"] for scene in scenes
             for kind, given in zip(scene.molecules, scene.data["molecules"])}  # fmt: skip
    species = sorted({name for beads, *_ in kinds for name in beads})
    of = f" of {' and '.join(species)}" if len(species) > 1 else ""
    branched = any(not kind.is_linear for scene in scenes for kind in scene.molecules)
    if branched or any(len(set(beads)) > 1 for beads, *_ in kinds):
        return f"molecules {', '.join(kinds.values())}"
    lengths = [len(beads) for beads, *_ in kinds]
    return f"monomers{of}" if set(lengths) == {1} else f"chains{of}, N = {span(lengths)}"


def _forces(scenes):
    """Repulsion, masses, and what else acts, each page by its own caption."""
    species = scenes[0].species
    yield f"{_by_species('a', species, [scene.repulsion for scene in scenes])} kT/r_c"
    if any(scene.masses is not None for scene in scenes):
        tables = [[1] * len(species) if s.masses is None else s.masses for s in scenes]
        yield f"masses {_by_species('m', species, tables)}"
    terms = [page for scene in scenes for page in scene.terms.values()]
    for kind in dict.fromkeys(map(type, terms)):
        if kind.caption is not None:
            found = [page for page in terms if type(page) is kind]
            yield _of_page(kind, found, len(scenes[0].box))


def _of_page(kind, pages, dimension):
    """The caption of a page with the settings that it has in some scenes."""
    given: dict[str, list] = {}  # values of each setting, those of all species or axes
    for plain in [page.plain() for page in pages]:
        for law in plain.values() if is_table(plain) else [plain]:
            for name, each in law.items() if isinstance(law, dict) else ():
                several = each.values() if isinstance(each, dict) else np.ravel(each).tolist()
                given.setdefault(name, []).extend(several)
    numbers = [name for name in given if {*map(type, given[name])} <= {int, float}]
    plain_text = ", ".join(f"{name} {{{name}}}" for name in numbers)
    text = kind.caption or f"{kind.key.replace('_', ' ')}: {plain_text}".removesuffix(": ")

    def if_given(found):
        names = SETTING.findall(found[1])
        other = (set(given.get(n, ())) - {kind.model_fields[n].default} for n in names)
        return found[1] if any(other) else ""

    return IF_GIVEN.sub(if_given, text).format(
        dimension=dimension, **{name: span(values) for name, values in given.items()}
    )


def _by_species(symbol, species, tables):
    """a_AA = a_BB = 25, a_AB = 37: species or pairs, with longer names a_(W1 tail), by values."""
    alike = {}
    for at in combinations_with_replacement(range(len(species)), np.ndim(tables[0])):
        names = [species[k] for k in at]
        of = "".join(names) if max(map(len, names)) == 1 else f"({' '.join(names)})"
        values = span([np.asarray(table)[at] for table in tables])
        alike.setdefault(values, []).append(f"{symbol}_{of}")
    return ", ".join(f"{' = '.join(named)} = {values}" for values, named in alike.items())


def _thermostat(scenes):
    """sigma^2 = 2 gamma kT; distribution of the noise."""
    thermostats = [scene.data["thermostat"] for scene in scenes]
    bath = "Langevin thermostat, " if thermostats[0]["kind"] == "langevin" else ""
    noise = span([each["noise"] for each in thermostats])
    frictions = [scene.friction for scene in scenes]
    if any(np.ndim(friction) for friction in frictions):
        names, size = scenes[0].species, len(scenes[0].species)
        tables = [np.broadcast_to(friction, [size] * (1 if bath else 2)) for friction in frictions]
        return f"{bath}{_by_species('gamma', names, tables)}, {noise} noise"
    gamma = span([each["gamma"] for each in thermostats], counted=False)
    if gamma == "0":
        return "no thermostat"
    sigma = span([round((2 * each["gamma"] * each["kT"]) ** 0.5, 3) for each in thermostats])
    return f"{bath}sigma = {sigma} (gamma = {gamma}), {noise} noise"
