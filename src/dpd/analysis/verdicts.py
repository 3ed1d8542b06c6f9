"""Published numbers against ours."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from dpd.digest import ROOT
from dpd.errors import UserError
from dpd.schema import read_yaml

PUBLISHED = ROOT / "paper_figures" / "published.yaml"
COLUMNS = [
    "paper", "figure", "quantity", "published", "published_error", "value", "error",
    "deviation_sigma", "verdict", "note",
]  # fmt: skip
REPLICATED, DEVIATES, NOT_REACHED = "replicated", "deviates", "not reached at this scale"
AGREE = 2.0  # combined standard errors


@dataclass(frozen=True)
class Measured:
    """Our number for a published one.

    Attributes
    ----------
    value, error : float
        The error is one standard error.
    note : str
        How it was found, for the table.
    undecided : str
        Why this run cannot decide; empty if it can.
    """

    value: float
    error: float
    note: str = ""
    undecided: str = ""


def published(paper):
    """Published numbers of a paper, if it has any: name to what published.yaml says of it."""
    return read_yaml(PUBLISHED).get(paper, {})


def judge(entry, measured):
    """Compare one published number with ours.

    Replicated is within two standard errors of the combined errors, or within the rounding
    of the published value, or inside the range that the paper states. A measurement whose
    error is larger than both the published value and its error decides nothing, unless the
    value is zero.

    Parameters
    ----------
    entry : dict
        ``value`` with ``error`` or ``rounding``, or ``range`` [low, high] with null for an
        open end.
    measured : Measured

    Returns
    -------
    verdict : str
    deviation : float
        In combined standard errors; NaN where undecided.
    """
    if measured.undecided or not np.isfinite(measured.value):
        return NOT_REACHED, np.nan
    if "range" in entry:
        low, high = entry["range"]
        low, high = -np.inf if low is None else low, np.inf if high is None else high
        outside = max(low - measured.value, measured.value - high, 0.0)
        deviation = outside / measured.error if measured.error > 0 else (np.inf if outside else 0.0)
        return (REPLICATED if deviation <= AGREE else DEVIATES), deviation
    difference = measured.value - entry["value"]
    # Rounding is a uniform error of half a last digit either way.
    own = entry.get("error", entry.get("rounding", 0.0) / np.sqrt(3.0))
    combined = np.hypot(own, measured.error)
    deviation = (
        difference / combined if combined > 0 else np.inf * difference if difference else 0.0
    )
    if entry["value"] != 0 and measured.error > max(abs(entry["value"]), own):
        return NOT_REACHED, deviation
    rounded = abs(difference) <= entry.get("rounding", 0.0)
    return (REPLICATED if rounded or abs(deviation) <= AGREE else DEVIATES), deviation


def rows(paper, figure, measured):
    """Verdict rows of one figure, in the order of published.yaml.

    Parameters
    ----------
    paper, figure : str
    measured : dict of str to Measured

    Returns
    -------
    pandas.DataFrame

    Raises
    ------
    UserError
        If a measured name is not published, or a published number of this figure has no
        counterpart and no reason for that.
    """
    entries = {k: e for k, e in published(paper).items() if e["figure"] == figure}
    unknown = set(measured) - set(entries)
    if unknown:
        raise UserError(f"{PUBLISHED}: {paper}: {figure} measures {sorted(unknown)}, not listed")
    table = []
    for name, entry in entries.items():
        if name not in measured and "pending" not in entry:
            raise UserError(f"{PUBLISHED}: {paper}.{name}: {figure} does not measure it")
        ours = measured.get(name) or Measured(np.nan, np.nan, "", entry["pending"])
        verdict, deviation = judge(entry, ours)
        reason = ours.undecided
        if verdict == NOT_REACHED and not reason:
            made = np.isfinite(ours.value)
            reason = (
                "the error is larger than what is published" if made else "no run in this study"
            )
        notes = [entry.get("note"), ours.note, reason]
        table.append({
            "paper": paper,
            "figure": figure,
            "quantity": entry["quantity"],
            "published": entry.get("value", _range_text(entry.get("range"))),
            "published_error": entry.get("error", entry.get("rounding", np.nan)),
            "value": ours.value,
            "error": ours.error,
            "deviation_sigma": round(float(deviation), 2),
            "verdict": verdict,
            "note": "; ".join(note for note in notes if note),
        })  # fmt: skip
    return pd.DataFrame(table, columns=COLUMNS)


def _range_text(limits):
    if limits is None:
        return ""
    low, high = limits
    if low is None:
        return f"< {high:g}"
    return f"> {low:g}" if high is None else f"{low:g} to {high:g}"
