"""The field's notation, typeset: `a_AA = 25`, `rho`, `r_c^3`, `2e-7` as HTML."""

import re

from markupsafe import Markup, escape

GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "Delta": "Δ", "epsilon": "ε",
    "eta": "η", "kappa": "κ", "lambda": "λ", "mu": "μ", "nu": "ν", "xi": "ξ", "pi": "π",
    "rho": "ρ", "sigma": "σ", "tau": "τ", "phi": "φ", "chi": "χ", "omega": "ω",
}  # fmt: skip
_GREEK = "|".join(GREEK)
_NUMBER = r"[+-]?\d+(?:\.\d+)?"
# In this order, on text whose <, > and & are escaped already.
_RULES = [
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
    """Plain notation as HTML; what stands in backticks is code and stays as it is.

    Parameters
    ----------
    text : str
        As captions, verdict tables and units have it.

    Returns
    -------
    markupsafe.Markup
        With everything else escaped.
    """
    parts = str(text).split("`")
    for place, part in enumerate(parts):
        safe = str(escape(part))
        parts[place] = f"<code>{safe}</code>" if place % 2 else _typeset(safe)
    return Markup("".join(parts))


def _typeset(safe):
    for pattern, put in RULES:
        safe = pattern.sub(put, safe)
    return safe
