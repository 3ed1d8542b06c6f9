"""Two studies held against each other: whether their error bars say how far they differ."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from scipy.special import fdtr

from dpd.analysis.statistics import COVERAGE, MANY, widening
from dpd.errors import UserError
from dpd.pipeline.paths import results_of
from dpd.report.archive import ARCHIVE
from dpd.report.figures import joined, read_verdicts

KEY = ["paper", "figure", "quantity"]
DRAWS = 400  # of two errors, which say how far their values should differ
WORST = 10  # rows that are listed, of each kind
ROUNDING = 1e-9  # of the square of an error: what is left of one that is systematic
FACTORS = (2, 3)  # by which error bars should not differ
ENOUGH = 20  # rows from which on a paper's rms z says something
MEANING = (
    "z = (a - b) / sqrt(e_a^2 + e_b^2), e being half a 95 % interval over 1.96 without the "
    "systematic part that both\nstudies share; then what the degrees of freedom (df) predict for "
    "its rms; ratio: the larger error bar over the\nsmaller, how often it is beyond 2 and 3, and "
    "how often the df predict that; flips: verdicts that differ; missing:\nvalues that one study "
    "alone has, which have no verdict."
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
    ``ratio`` is the larger such error over the smaller; they are NaN where a row has none.
    ``likely_2`` and ``likely_3`` are how likely the degrees of freedom make the ratio larger than
    that. ``flip`` is whether the verdicts differ, of rows with both values; ``missing`` is whether
    one study alone has the value.
    """
    both = one.merge(other, on=KEY, suffixes=("", "_b"), validate="one_to_one")
    there = np.isfinite(both[["value", "value_b"]].to_numpy(dtype=float)).sum(axis=1)
    errors, shared = (
        both[[name, f"{name}_b"]].to_numpy(dtype=float) for name in ("error", "systematic")
    )
    squares = errors**2 - np.nan_to_num(shared) ** 2
    known = (squares > ROUNDING * errors**2).all(axis=1)
    errors = np.sqrt(np.where(known[:, None], squares, np.nan))
    both["z"] = (both.value - both.value_b) / np.hypot(*errors.T)
    both["ratio"] = errors.max(axis=1) / errors.min(axis=1)
    degrees = both[["degrees", "degrees_b"]].to_numpy(dtype=float)
    both["likely_z"] = [_mean_square(pair) if k else np.nan for pair, k in zip(degrees, known)]
    n, m = degrees.T
    wide = (widening(n) / widening(m)) ** 2
    for factor in FACTORS:
        either = fdtr(n, m, 1 / (wide * factor**2)) + 1 - fdtr(n, m, factor**2 / wide)
        both[f"likely_{factor}"] = np.where(np.isfinite(both.z), either, np.nan)
    both["missing"] = there == 1
    both["flip"] = (there == 2) & (both.verdict != both.verdict_b)
    return both


def _mean_square(degrees: np.ndarray) -> float:
    """Of z, of values whose errors have so many degrees of freedom; Student's t makes it < 1."""
    many = np.minimum(np.nan_to_num(degrees, nan=np.inf), MANY)
    drawn = np.random.default_rng(1).chisquare(many, (DRAWS, 2)) / many
    return float(np.mean(2 / (widening(many) ** 2 * drawn).sum(axis=1)))


def as_text(rows: pd.DataFrame, one: pd.DataFrame, other: pd.DataFrame) -> str:
    """What `compared` found, per paper and in all, then the rows that differ most."""
    parts = [*rows.groupby("paper"), ("all", rows)]
    table = pd.DataFrame([_summary(part) for _, part in parts], index=[name for name, _ in parts])
    lines = [table.to_string()]
    unlike = len(one) + len(other) - 2 * len(rows)
    lines += [f"rows that one table alone has: {unlike}"] if unlike else []
    lines += ["", MEANING]
    known = rows[np.isfinite(rows.z)]
    for title, part, why in (
        ("largest |z|", known.iloc[(-known.z.abs()).argsort()[:WORST]], "z"),
        ("error bars that differ most", known.nlargest(WORST, "ratio"), "ratio"),
        ("verdicts that differ", rows[rows.flip], ""),
        ("values that one study lacks", rows[rows.missing], ""),
    ):
        lines += ["", f"{title}:"] + [_said(row, why) for row in part.to_dict("records")]
    return "\n".join(lines)


def _summary(rows):
    """One line of the table."""
    z, ratio = rows.z.dropna(), rows.ratio[np.isfinite(rows.z)]
    n = len(z)
    rms, likely = np.sqrt([(z**2).mean(), rows.likely_z.mean()]) if n else (np.nan, np.nan)
    more = {
        f"ratio>{factor}": f"{(ratio > factor).sum()} of {rows[f'likely_{factor}'].sum():.1f}"
        for factor in FACTORS
    }
    return {
        "rows": len(rows),
        "with z": n,
        "rms z": f"{rms:.2f} of {likely:.2f}",
        "allowed": f"1 ± {2 / np.sqrt(2 * n):.2f}" if n >= ENOUGH else "-",
        ">1.96": f"{(z.abs() > COVERAGE).mean():.1%}",
        **more,
        "flips": rows.flip.sum(),
        "missing": rows.missing.sum(),
        "no df": (rows.degrees.isna() & np.isfinite(rows.z)).sum(),
    }


def _said(row, why):
    """One line on a row."""
    two = (f"{row[f'value{s}']:.5g} ± {row[f'error{s}']:.2g} (df {row[f'degrees{s}']:.3g}, "
           f"{row[f'verdict{s}'].split()[0]})" for s in ("", "_b"))  # fmt: skip
    shown = f"{row[why]:6.2f}  " if why else ""
    return f"  {shown}{row['paper']} {row['figure']}: {row['quantity']}: {' and '.join(two)}"
