"""Bins of distributions."""

import numpy as np


def middles(edges: np.ndarray) -> np.ndarray:
    """(bins,) array: the middles of bins."""
    return 0.5 * (edges[1:] + edges[:-1])


def density(values: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """(bins,) array: share of some numbers in each of equal bins from 0 on, over its width."""
    counts, _ = np.histogram(values, len(edges) - 1, (0.0, edges[-1]))  # faster than with edges
    return counts / (values.size * edges[1])
