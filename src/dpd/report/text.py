"""Numbers as text."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping


def with_error(value: float, error: float | None = None) -> str:
    """A number with as many digits as its error has meaning for: two of the error's."""
    if not np.isfinite(value):
        return "–"
    if error is None or not np.isfinite(error) or error <= 0:
        return f"{value:.4g}"
    first = int(np.floor(np.log10(error)))
    if not -4 <= np.floor(np.log10(max(abs(value), error))) < 6:
        power = int(np.floor(np.log10(max(abs(value), error))))
        return f"({with_error(value / 10.0**power, error / 10.0**power)})e{power}"
    digits = max(0, 1 - first)
    return f"{value:.{digits}f} ± {error:.{digits}f}"


def in_percent(errors: Mapping[str, tuple[float, float]]) -> dict[str, str]:
    """Relative errors, each with its standard error, in per cent.

    Parameters
    ----------
    errors : dict of str to (float, float)

    Returns
    -------
    dict of str to str
    """
    return {name: with_error(100 * value, 100 * error) for name, (value, error) in errors.items()}


def with_range(middle: float, low: float, high: float) -> str:
    """A number with the range that it was met in."""
    if not np.isfinite(middle):
        return "–"
    return f"{middle:.3g} ({low:.3g} to {high:.3g})"


def published_text(row: Mapping[str, Any]) -> str:
    """Published value as printed in the table: with its error or its rounding, if it has any."""
    try:
        text = f"{float(row['published']):g}"
    except ValueError:
        return row["published"]
    if np.isfinite(row["published_error"]):
        text += f" ± {row['published_error']:.2g}"
    if np.isfinite(row["rounding"]):
        text += f", rounded by {row['rounding']:.2g}"
    return text
