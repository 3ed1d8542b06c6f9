"""Two studies held against each other: whether their error bars say how far they differ."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from dpd.analysis.statistics import COVERAGE, MANY, widening
from dpd.errors import UserError
from dpd.pipeline.paths import results_of
from dpd.report.archive import ARCHIVE
from dpd.report.figures import joined, read_verdicts

KEY = ["paper", "figure", "quantity"]
DRAWS = 400  # of two errors, which say how far their values should differ
WORST = 10  # rows that are listed
ROUNDING = 1e-9  # of the square of an error: what is left of one that is systematic
MEANING = (
    "z = (a - b) / sqrt(e_a^2 + e_b^2), e being half a 95 % interval over 1.96 without the "
    "systematic part that both\nstudies share; then what the degrees of freedom (df) predict for "
    "its rms; flips: verdicts that differ; missing: values\nthat one study alone has, which have "
    "no verdict."
)


def table_of(name: str | Path) -> pd.DataFrame:
    """The verdicts of a study: of its figures as far as they are drawn, or of one table.

    ``name``: of a verdict table, a folder of results or of an archive, or a study. Raises
    `UserError` if there are no verdicts.
    """
    places = (Path(name), Path(results_of(str(name)).folder), ARCHIVE / str(name))
    for place in places:
        drawn = [place] if place.is_file() else sorted(place.glob("*/figures/*.csv"))
        if files := drawn or sorted(place.glob("verdicts.csv")):
            return joined(map(read_verdicts, files))
    raise UserError(
        f"{name}: no verdicts there; name a folder below results or results/archive, or a table "
        "verdicts.csv"
    )


def compared(one: pd.DataFrame, other: pd.DataFrame) -> pd.DataFrame:
    """Rows that two verdict tables share, with columns of both, those of the second with ``_b``.

    ``z`` is the difference over the combined error without its systematic part, half a 95 %
    interval over 1.96, and ``likely_z`` the mean square that the degrees of freedom let expect;
    they are NaN where a row has no such error. ``flip`` is whether the verdicts differ, of rows
    with both values; ``missing`` is whether one study alone has the value.
    """
    both = one.merge(other, on=KEY, suffixes=("", "_b"), validate="one_to_one")
    there = both[["value", "value_b"]].notna().sum(axis=1)
    errors, shared, degrees = (
        both[[name, f"{name}_b"]].to_numpy(float) for name in ("error", "systematic", "degrees")
    )
    squares = errors**2 - np.nan_to_num(shared) ** 2
    known = (squares > ROUNDING * errors**2).all(axis=1)
    both["z"] = (both.value - both.value_b) / np.sqrt(np.where(known, squares.sum(axis=1), np.nan))
    both["likely_z"] = [_mean_square(pair) if k else np.nan for pair, k in zip(degrees, known)]
    both["missing"] = there == 1
    both["flip"] = (there == 2) & (both.verdict != both.verdict_b)
    return both


def _mean_square(degrees: np.ndarray) -> float:
    """Of z, of values whose errors have so many degrees of freedom; Student's t makes it < 1."""
    many = np.minimum(np.nan_to_num(degrees, nan=np.inf), MANY)
    drawn = np.random.default_rng(1).chisquare(many, (DRAWS, 2)) / many
    return float(np.mean(2 / (widening(many) ** 2 * drawn).sum(axis=1)))


def as_text(rows: pd.DataFrame) -> str:
    """What `compared` found, per paper and in all, then the rows that differ most."""
    parts = {**dict(list(rows.groupby("paper"))), "all": rows}
    table = pd.DataFrame({name: _summary(part) for name, part in parts.items()}).T
    lines = [table.to_string(), "", MEANING]
    for title, part in (
        ("largest |z|", rows.loc[rows.z.abs().nlargest(WORST).index]),
        ("verdicts that differ", rows[rows.flip]),
        ("values that one study lacks", rows[rows.missing]),
    ):
        lines += ["", f"{title}:"]
        for row in part.to_dict("records"):
            values = (
                f"{row[f'value{s}']:.5g} ± {row[f'error{s}']:.2g} (df "
                f"{row[f'degrees{s}']:.3g}, {row[f'verdict{s}'].split()[0]})"
                for s in ("", "_b")
            )
            name = f"{row['paper']} {row['figure']}: {row['quantity']}"
            lines.append(f"  z {row['z']:5.2f}  {name}: {' and '.join(values)}")
    return "\n".join(lines)


def _summary(rows):
    """One line of the table."""
    z = rows.z.dropna()
    rms, likely = np.sqrt((z**2).mean()), np.sqrt(rows.likely_z.mean())
    return {
        "rows": len(rows),
        "with z": len(z),
        "rms z": f"{rms:.2f} of {likely:.2f}",
        ">1.96": f"{(z.abs() > COVERAGE).mean():.1%}",
        "flips": rows.flip.sum(),
        "missing": rows.missing.sum(),
    }
