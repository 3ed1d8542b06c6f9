"""Two studies held against each other: whether their error bars say how far they differ."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import fdtr

from dpd.analysis.collect import reading
from dpd.analysis.statistics import COVERAGE, MANY, widening
from dpd.analysis.verdicts import COLUMNS, Measured, entry_of, judge
from dpd.errors import UserError
from dpd.pipeline.paths import results_of
from dpd.report.archive import ARCHIVE
from dpd.report.figures import joined

KEY = ["paper", "figure", "quantity"]
DRAWS = 400  # of two studies like these, which say how often their verdicts would differ
WORST = 10  # rows that are listed, of each kind
ROUNDING = 1e-9  # of the square of an error: what is left of one that is systematic
FACTORS = (2, 3)  # by which error bars should not differ
ENOUGH = 20  # rows from which on a paper's rms z says something
HEADER = (
    f"{'paper':18s} {'rows':>5s} {'with z':>6s} {'rms z':>11s} {'allowed':>9s} {'>1.96':>7s}   "
    f"{'ratio>2':>9s}   {'ratio>3':>9s}   {'flips':>15s} {'missing':>7s} {'no df':>7s}"
)
MEANING = (
    "z = (a - b) / sqrt(e_a^2 + e_b^2), e being half a 95 % interval over 1.96 without the "
    "systematic part that both\nstudies share; then what the degrees of freedom (df) predict for "
    "its rms; ratio: the larger error bar over the\nsmaller, how often it is beyond 2 and 3, and "
    "how often the df predict that; flips: verdicts that differ, and how\nmany the errors predict; "
    "missing: values that one study alone has, which have no verdict."
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
            return joined(map(_read, files)).reindex(columns=COLUMNS)
    raise UserError(
        f"{name}: no verdicts there; name a folder below results or results/archive, or a table "
        "verdicts.csv"
    )


def _read(path):
    with reading(path, "table of verdicts"):
        table = pd.read_csv(path)
    if lacking := {*KEY, "value", "error", "published", "verdict"} - set(table.columns):
        raise UserError(f"{path}: no column {', '.join(sorted(lacking))}; name a table of verdicts")
    return table


def compared(one: pd.DataFrame, other: pd.DataFrame) -> pd.DataFrame:
    """Rows that two verdict tables share, with columns of both, those of the second with ``_b``.

    ``z`` is the difference over the combined error without its systematic part, half a 95 %
    interval over 1.96, and ``likely_z`` the mean square that the degrees of freedom let expect;
    ``ratio`` is the larger such error over the smaller; they are NaN where a row has none.
    ``likely_2`` and ``likely_3`` are how likely the degrees of freedom make the ratio larger than
    that. ``flip`` is whether the verdicts differ, of rows with both values, ``likely_flip`` how
    likely that is with these errors; ``missing`` is whether one study alone has the value.
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
    rows = both.to_dict("records")
    both["likely_flip"] = [_likely_flip(row) if n == 2 else 0.0 for n, row in zip(there, rows)]
    return both


def _mean_square(degrees: np.ndarray) -> float:
    """Of z, of values whose errors have so many degrees of freedom; Student's t makes it < 1."""
    many = np.minimum(np.nan_to_num(degrees, nan=np.inf), MANY)
    drawn = np.random.default_rng(1).chisquare(many, (DRAWS, 2)) / many
    return float(np.mean(2 / (widening(many) ** 2 * drawn).sum(axis=1)))


def _likely_flip(row: dict[str, Any]) -> float:
    """How likely two studies with the errors of a row differ in its verdict.

    The truth lies about the mean of both values as far as their errors allow; two values are drawn
    about it, with error bars as their degrees of freedom let them scatter. A verdict that does not
    follow from value and error, as of a run that is too short, stays.
    """
    errors = np.array([row["error"], row["error_b"]], dtype=float)
    entry = entry_of(row)
    decided = all(
        judge(entry, Measured(row[f"value{side}"], row[f"error{side}"])).verdict
        == row[f"verdict{side}"] for side in ("", "_b")
    )  # fmt: skip
    if not decided or not (errors > 0).all():
        return 0.0
    degrees = np.nan_to_num([row["degrees"], row["degrees_b"]], nan=np.inf)
    wide = widening(degrees)
    sigma = np.sqrt(((errors / wide) ** 2).mean())
    rng = np.random.default_rng(1)
    truth = rng.normal((row["value"] + row["value_b"]) / 2, sigma / np.sqrt(2), (DRAWS, 1))
    values, freely = rng.normal(truth, sigma, (DRAWS, 2)), np.minimum(degrees, MANY)
    drawn = sigma * wide * np.sqrt(rng.chisquare(freely, (DRAWS, 2)) / freely)
    differ = 0
    for pair in zip(values, drawn):
        first, second = (judge(entry, Measured(*each)).verdict for each in zip(*pair))
        differ += first != second
    return differ / DRAWS


def as_text(rows: pd.DataFrame, one: pd.DataFrame, other: pd.DataFrame) -> str:
    """What `compared` found, per paper and in all, then the rows that differ most."""
    lines = [HEADER, *(_line(paper, part) for paper, part in rows.groupby("paper"))]
    lines.append(_line("all", rows))
    unlike = len(one) + len(other) - 2 * len(rows)
    lines += [f"rows that one table alone has: {unlike}"] if unlike else []
    lines += ["", MEANING]
    known = rows[np.isfinite(rows.z)]
    for title, part, why in (
        ("largest |z|", known.iloc[(-known.z.abs()).argsort()[:WORST]], "z"),
        ("error bars that differ most", known.nlargest(WORST, "ratio"), "ratio"),
        ("verdicts that differ", rows[rows.flip], "likely_flip"),
        ("values that one study lacks", rows[rows.missing], "missing"),
    ):
        lines += ["", f"{title}:"] + [_said(row, why) for row in part.to_dict("records")]
    return "\n".join(lines)


def _line(name, rows):
    """One line of the table."""
    z, ratio = rows.z.dropna(), rows.ratio[np.isfinite(rows.z)]
    n, flips = len(z), rows.likely_flip
    allowed = f"1 ± {2 / np.sqrt(2 * n):.2f}" if n >= ENOUGH else "-"
    squares = [(z**2).mean(), rows.likely_z.mean()] if n else [np.nan] * 2
    (rms, likely), beyond = np.sqrt(squares), np.nan if n == 0 else (z.abs() > COVERAGE).mean()
    more = [f"{(ratio > factor).sum():3d} {rows[f'likely_{factor}'].sum():5.1f}"
            for factor in FACTORS]  # fmt: skip
    spread = np.sqrt((flips * (1 - flips)).sum())
    return (
        f"{name:18s} {len(rows):5d} {n:6d} {rms:6.2f} {likely:4.2f} {allowed:>9s} {beyond:7.1%}   "
        f"{more[0]}   {more[1]}   {rows.flip.sum():3d} {flips.sum():5.1f} ± {spread:3.1f} "
        f"{rows.missing.sum():7d} {(rows.degrees.isna() & np.isfinite(rows.z)).sum():7d}"
    )


def _said(row, why):
    """One line on a row."""
    two = (f"{row[f'value{s}']:.5g} ± {row[f'error{s}']:.2g} (df {row[f'degrees{s}']:.3g}, "
           f"{row[f'verdict{s}'].split()[0]})" for s in ("", "_b"))  # fmt: skip
    shown = f"{row[why]:6.2f}  " if why != "missing" else ""
    return f"  {shown}{row['paper']} {row['figure']}: {row['quantity']}: {' and '.join(two)}"
