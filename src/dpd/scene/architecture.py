"""The grammar of architectures: ``A 3 B 9``, ``A 3 (B 2) A 3``, ``(A 2 B) 4``.

A species with a number is a run of beads. A bracket without a number behind it is a branch, which
hangs on the bead before it. A bracket with a number is a group, repeated along the chain. Both
nest, so ``(A (B 2)) 10`` is a comb. Rings cannot be written.
"""

from __future__ import annotations

import re
from typing import Any

from dpd.errors import shown

MOST_BEADS = 10**6  # of one molecule
MOST_NESTED = 50  # brackets in brackets
AROUND = 30  # characters that a message shows on either side of a mistake
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_+-]{0,31}")
NUMBER = re.compile(r"[0-9]+")
WORD = re.compile(r"[()]|[^\s()]+")
RULES = (
    "write species and repeats as 'A 3 B 9'; behind a bead a branch in brackets, 'A 3 (B 2) A 3'; "
    "groups with their repeats, '(A 2 B) 4'; a species is a letter, then letters, digits, _, + or "
    "-, 32 at most; there are no rings"
)


def tree_of(architecture: str) -> tuple[tuple[str, ...], tuple[int, ...]]:
    """The molecule that an architecture describes, such as ``A 3 (B 2) A 3``.

    Returns
    -------
    tuple of str
        The species of each bead.
    tuple of int
        The bead on which each one hangs, always one with a lower number; -1 for the first.

    Raises
    ------
    ValueError
        If it cannot be read; with the place marked.
    """
    beads: list[str] = []
    parents: list[int] = []
    _write_out(_parts(architecture), beads, parents, -1)
    return tuple(beads), tuple(parents)


def length_of(architecture: str) -> int:
    """How many beads an architecture describes, without writing them out.

    Raises
    ------
    ValueError
        As `tree_of` has it, also for more than `MOST_BEADS` beads.
    """
    beads = _count(_parts(architecture))
    if beads > MOST_BEADS:
        raise ValueError(
            f"{shown(architecture)} is a molecule of {beads:.6g} beads; allowed: <= {MOST_BEADS}"
        )
    return beads


def _parts(architecture: str) -> list[tuple[Any, int | None]]:
    """Species or parts in brackets, each with its repeats; a branch has none."""

    def refuse(start, end, problem):
        raise ValueError(f"{_marked(architecture, start, end)}: {problem}; {RULES}")

    words = list(WORD.finditer(architecture))
    open_brackets: list[tuple[int, list]] = [(0, [])]  # where each is, and what is in it so far
    for number, word in enumerate(words):
        text, parts, span = word[0], open_brackets[-1][1], word.span()
        times = _times(words[number + 1], refuse) if number + 1 < len(words) else None
        if text == "(":
            open_brackets.append((span[0], []))
            if len(open_brackets) > MOST_NESTED + 1:
                refuse(*span, f"brackets are nested deeper than {MOST_NESTED}")
        elif text == ")":
            opened, _ = open_brackets.pop()
            if not open_brackets:
                refuse(*span, "no bracket is open that this one could close")
            if not parts:
                refuse(opened, opened + 1, "the bracket is empty")
            if times is None and not open_brackets[-1][1]:
                text = "there is no bead before this branch that it could hang on"
                refuse(opened, opened + 1, text)
            open_brackets[-1][1].append((parts, times))
        elif NAME.fullmatch(text):
            parts.append((text, times or 1))
        elif not NUMBER.fullmatch(text):
            refuse(*span, "this is neither a species, nor a number, nor a bracket")
        elif number == 0 or words[number - 1][0] == "(" or NUMBER.fullmatch(words[number - 1][0]):
            refuse(*span, "a number of repeats stands behind a species or a bracket")
    opened, parts = open_brackets[-1]
    if len(open_brackets) > 1:
        refuse(opened, opened + 1, "this bracket is not closed")
    if not parts:
        refuse(0, 0, "there are no beads")
    return parts


def _times(word, refuse):
    """The repeats that a word gives; None if it is something else."""
    if not NUMBER.fullmatch(word[0]):
        return None
    if len(word[0]) > len(str(MOST_BEADS)):
        refuse(*word.span(), f"so many repeats are not allowed: <= {MOST_BEADS}")
    if int(word[0]) == 0:
        refuse(*word.span(), "repeats are at least 1")
    return int(word[0])


def _marked(text, start, end):
    """The text around a word, which stands between arrows."""
    before = text[:start] if start <= AROUND else f"...{text[start - AROUND : start]}"
    behind = text[end:] if len(text) - end <= AROUND else f"{text[end : end + AROUND]}..."
    middle = text[start:end] if end - start <= AROUND else f"{text[start : start + AROUND]}..."
    return shown(f"{before}>>>{middle}<<<{behind}", str)


def _count(parts):
    """Beads of some parts."""
    return sum(
        (times or 1) * (1 if isinstance(part, str) else _count(part)) for part, times in parts
    )


def _write_out(parts, beads, parents, last):
    """Append beads that go on from bead ``last``; return the last one along the chain."""
    for part, times in parts:
        here = last
        for _ in range(times or 1):
            if isinstance(part, str):
                beads.append(part)
                parents.append(last)
                last = len(beads) - 1
            else:
                last = _write_out(part, beads, parents, last)
        last = here if times is None else last
    return last
