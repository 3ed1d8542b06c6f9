"""Tables of what files hold: run.nc, sweep files, verdict tables. For pages in config.

Names, dimensions, units and meanings come from the observables and from `dpd.analysis.collect`
themselves: a tiny system is set up, and no step of it is run.
"""

import json
from contextlib import suppress
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory

from dpd import files
from dpd.analysis.collect import RECORDED, collect
from dpd.errors import UserError
from dpd.observe.common.measured import observables
from dpd.page import Observable, find, names
from dpd.pipeline.sweep import Axis, Point, Sweep
from dpd.report.markdown import markdown_table
from dpd.scene.scene import Scene
from dpd.stages import run_sources
from dpd.start.common.make import system_of

FLUID = {
    "dimension": 3,
    "box": 6,
    "molecules": [{"architecture": "A 2 B 2", "count": 162}],
    "repulsion": {"A A": 25, "A B": 30, "B B": 25},
    "bond": {"stiffness": 50, "length": 0.5},
    "integrator": {"scheme": "gw-vv", "dt": 0.01},
    "steps": {"equilibrate": 0, "sample": 1000},
}
PLANE = FLUID | {"dimension": 2, "box": 18}
WALLED = FLUID | {"walls": {"axis": "y", "repulsion": 25}}
# Some observables have more in such scenes.
MORE = (
    ({"shear": {"rate": 0.1}}, "under shear"),
    ({"walls": WALLED["walls"]}, "between walls"),
    ({"pressure": {"target": 1}}, "at constant pressure"),
)
VERDICT_COLUMNS = {
    "paper": "the paper",
    "figure": "the figure whose file measures the number",
    "quantity": "what is compared",
    "where": "where it is printed",
    "kind": "*simulated*: the paper prints it, and it is compared with simulation; *closed form*: "
    "the paper prints it, and it is compared with a formula; *check*: our own, not printed",
    "limits": "who set the range or the rounding: the text, or we",
    "published": "the printed number, or the range that a claim allows",
    "published_error": "its standard error",
    "rounding": 'half of its last printed digit, or of what a word like "about" allows',
    "rival": "what it must be told from, if not from 0",
    "value": "our number",
    "error": "its standard error, widened by Student's t where few independent samples have fixed "
    "it, so that 1.96 of it make a 95 % interval; none if the run is shorter than about 20 "
    "correlation times",
    "systematic": "the part of the error that more sampling would not lower: of points that do not "
    "follow the law that is fitted, of a choice of fluids, of bins",
    "degrees": "degrees of freedom that have fixed the rest of it; none where they are not known",
    "deviation_sigma": "the difference in combined standard errors, rounding included; of a range: "
    "how far the value lies outside",
    "resolution": "the smallest difference that this run would have called a deviation",
    "verdict": "*replicated*: within two combined standard errors or within the rounding, or our "
    "95 % interval lies inside the range; *deviates*: beyond that, or our interval lies outside "
    "the range; *not reached at this scale*: the run cannot decide",
    "note": "how the number was found, and why a run cannot decide",
}


def run_table() -> str:
    """Markdown: the variables of run.nc, observable by observable."""
    rows = [
        [f"`{observable}`", f"`{name}`", ", ".join(dimensions), units, escape(meaning)]
        for observable in names(Observable)
        for name, (dimensions, _, units, meaning) in _all_variables(observable).items()
    ]
    return markdown_table(["observable", "variable", "dimensions", "units", "meaning"], rows)


def sweep_table() -> str:
    """Markdown: the variables that a sweep file has beside those of its runs."""
    collected = _collected()
    rows = [
        [f"`{name}`", variable.attrs["units"], escape(variable.attrs["long_name"])]
        for name, variable in collected.items()
    ]
    return markdown_table(["variable", "units", "meaning"], rows)


def verdict_table() -> str:
    """Markdown: the columns of verdicts.csv."""
    rows = [[f"`{name}`", meaning] for name, meaning in VERDICT_COLUMNS.items()]
    return markdown_table(["column", "meaning"], rows)


def _scene(observable, more=(), **settings):
    """The first of some scenes that an observable can look at."""
    asked = dict(more) | {"observe": [{observable: settings}]}
    for base in (FLUID, PLANE):
        with suppress(UserError):
            return Scene(base | asked, "example")
    return Scene(WALLED | asked, "example")


def _all_variables(observable):
    """Variables of an observable, with those that it has in some scenes alone."""
    found = _variables(_scene(observable))
    for key, where in MORE:
        with suppress(UserError):  # it cannot look at such a scene
            for name, variable in _variables(_scene(observable, key)).items():
                dimensions, array, units, meaning = variable
                found.setdefault(name, (dimensions, array, units, f"{meaning}, {where}"))
    for key, field in find(Observable, observable).model_fields.items():
        if field.default is False:
            for name, variable in _variables(_scene(observable, **{key: True})).items():
                dimensions, array, units, meaning = variable
                found.setdefault(name, (dimensions, array, units, f"{meaning}, with `{key}: true`"))
    return found


def _variables(scene):
    """Variables of the one observable of a scene, as long as nothing has moved."""
    asked, *_ = observables(scene, system_of(scene))
    return asked.variables()


def _collected():
    """A sweep of one run that observes kT and momentum, both zero."""
    scene = _scene("thermo", pressure=False)
    numbers = dict.fromkeys(RECORDED, 1) | {"beads": scene.beads}
    attributes = numbers | {
        "scene": json.dumps(scene.data),
        "scene_digest": scene.digest,
        "sources": run_sources(scene),
        "numpy": "",
        "numba": "",
    }
    variables = {
        name: (dimensions, array if name == "time" else 0.0 * array, units, meaning)
        for name, (dimensions, array, units, meaning) in _variables(scene).items()
    }
    replica = Axis("replica", (0,), "1", "replica")
    sweep = Sweep("example", (replica,), (Point("replica=0", (0,), scene),))
    with TemporaryDirectory() as folder:
        path = Path(folder) / "run.nc"
        files.write(path, variables, attributes)
        return collect(sweep, [path])
