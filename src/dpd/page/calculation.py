"""What a sweep of theory calculates at a point: a page of a paper, in its calculations.py."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, NamedTuple

from dpd.page.base import Page

if TYPE_CHECKING:
    import numpy as np


class Quantity(NamedTuple):
    """A calculated number or array; what has the name of its only dimension is a coordinate."""

    value: float | np.ndarray
    units: str
    long_name: str
    dims: tuple[str, ...] = ()


class Calculation(Page):
    """Settings of a point and what follows from them, found in a paper's file by its key.

    A setting ``seed`` that is not given is the seed of the study.
    """

    package: ClassVar[str] = "paper_figures"

    def calculate(self) -> dict[str, Quantity]:
        """Numbers and arrays by name.

        Raises
        ------
        ValueError
            If there is no solution, with why.
        """
        raise NotImplementedError
