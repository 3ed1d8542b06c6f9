"""Measurements of the engine: by name into files of their own, or all of its speed in words."""

from __future__ import annotations

import os
import time
from datetime import UTC, datetime
from pathlib import Path

import numba
import numpy as np
import pandas as pd

from benchmarks.beside import beside_lammps
from benchmarks.costs import features, observing, observing_as_text, schemes, whole_runs
from benchmarks.scaling import scaling
from benchmarks.systems import STUDIES, WORKLOADS
from benchmarks.tension import tension_beside_lammps
from dpd.analysis.collect import save
from dpd.digests import stage_digest
from dpd.errors import UserError, suggestion
from dpd.files import replace_whole
from dpd.pipeline.paths import commit, processor

# The names that dpd.pipeline.paper allows.
MEASUREMENTS = {
    "lammps": beside_lammps,
    "scaling": scaling,
    "schemes": schemes,
    "features": features,
    "tension": tension_beside_lammps,
}
HISTORY = Path(__file__).with_name("history.csv")
COLUMNS = ["commit", "date", "processor", "system", "rate", "ratio"]


def measure(name, path, say=print, **sizes):
    """Make one of `MEASUREMENTS` and write it; ``sizes`` make it smaller than it is.

    Raises
    ------
    UserError
        For a name that is not known.
    """
    if name not in MEASUREMENTS:
        raise UserError(f"measure: {name!r} is not known; {suggestion(name, MEASUREMENTS)}")
    begun = time.perf_counter()
    data = MEASUREMENTS[name](say=say, **sizes)
    data.attrs |= {
        "measurement": name,
        "processor": processor(),
        "cores": len(os.sched_getaffinity(0)),
        "sources": stage_digest("measure"),
        "seconds": time.perf_counter() - begun,
        "numpy": np.__version__,
        "numba": numba.__version__,
    }
    data.attrs["description"] += f" On {processor()}, {data.attrs['cores']} core(s)."
    save(data, path)


def bench():
    """Print rates and their ratios beside the last ones of this processor, and keep them."""
    say = lambda line: print(line, flush=True)  # noqa: E731
    data = beside_lammps(snapshots=0, say=say)
    rates = {
        name: (WORKLOADS[name].system, data.own_rate.values[k], data.lammps_rate.values[k])
        for k, name in enumerate(data.workload.values.tolist())
    }
    wholes = whole_runs(say)
    rates |= {f"whole {name}": (STUDIES[name].system, w, b) for name, (b, w) in wholes.items()}
    found = rows_of(rates)
    print("W: beside LAMMPS; whole: a run with all that it observes, beside the bare loop")
    print(as_text(found, rates, history()))
    append(found)
    print(f"kept: {HISTORY}")
    print(observing_as_text(observing(say=say)))


def rows_of(rates):
    """Rows of the history: million bead-steps per second, and the median ratio of a turn.

    Parameters
    ----------
    rates : dict
        Name to system in words, and (turns,) rates of ours and of what that is compared with.
    """
    made = commit(), datetime.now(UTC).strftime("%Y-%m-%d"), processor()
    rows = [
        (*made, name, round(np.median(own) / 1e6, 3), round(np.median(own / other), 3))
        for name, (_, own, other) in rates.items()
    ]
    return pd.DataFrame(rows, columns=COLUMNS)


def as_text(found, rates, before):
    """Each system with its rate, its ratio, and the last ratio, or rate, of this processor."""
    lines = []
    for row in found.itertuples():
        system, own, _ = rates[row.system]
        line = f"{row.system:16s} {row.rate:6.2f} million bead-steps per second "
        line += f"({own.min() / 1e6:.2f} to {own.max() / 1e6:.2f}){_ratio(row)}"
        last = before[(before.processor == row.processor) & (before.system == row.system)]
        for then in last.tail(1).itertuples():
            line += f"; at {then.commit}: {then.rate:.2f}{_ratio(then)}"
        lines.append(f"{line}   {system}")
    return "\n".join(lines)


def _ratio(row):
    return "" if np.isnan(row.ratio) else f", ratio {row.ratio:.2f}"


def history():
    """What former runs of `bench` have found."""
    return pd.read_csv(HISTORY) if HISTORY.is_file() else pd.DataFrame(columns=COLUMNS)


def append(found):
    """Put rows at the end of the history."""
    whole = pd.concat([history(), found]) if HISTORY.is_file() else found
    replace_whole(HISTORY, lambda draft: whole.to_csv(draft, index=False))
