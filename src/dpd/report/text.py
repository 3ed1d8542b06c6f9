"""Numbers, names and the field's notation as text: `a_AA = 25`, `rho`, `r_c^3` as HTML."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from jinja2 import Environment, FileSystemLoader
from markupsafe import Markup, escape

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy.typing as npt

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
_RULES: list[tuple[str, Any]] = [
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
RULES = [(re.compile(pattern), put) for pattern, put in _RULES]


def typeset(text: str) -> Markup:
    """Plain notation as HTML; what stands in backticks is code and stays as it is."""
    parts = []
    for place, part in enumerate(str(text).split("`")):
        safe = str(escape(part))
        for pattern, put in RULES if place % 2 == 0 else ():
            safe = pattern.sub(put, safe)
        parts.append(f"<code>{safe}</code>" if place % 2 else safe)
    return Markup("".join(parts))


def label(figure: str) -> str:
    """What a figure is called: ``Figure 4``, the paper's number, or its own name."""
    numbered = NUMBERED.match(figure)
    return f"Figure {numbered[1]}" if numbered else f"Own figure: {figure.replace('_', ' ')}"


def named(paper: str) -> str:
    """groot_warren_1997 as Groot Warren 1997."""
    return paper.replace("_", " ").title()


def rendered(template: str, **values: Any) -> str:
    """A template of this folder, filled; what goes into HTML is escaped."""
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent), autoescape=template.endswith(".html"),
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


def in_percent(errors: Mapping[str, tuple[float, float]]) -> dict[str, str]:
    """Relative errors, each with its standard error, in per cent."""
    return {name: with_error(100 * value, 100 * error) for name, (value, error) in errors.items()}


def with_range(middle: float, low: float, high: float) -> str:
    """A number with the range that it was met in."""
    return f"{middle:.3g} ({low:.3g} to {high:.3g})" if np.isfinite(middle) else "–"


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
