"""Where the virial lies, in plain NumPy: every line against every slice and its images."""

import numpy as np

from tests.engine.reference import Reference


class StressedReference(Reference):
    """A `Reference` that keeps the line of every force, and what it adds to the virial."""

    def evaluate(self, velocity):
        """Forces as ever, with their lines."""
        self.lines = []
        super().evaluate(velocity)

    def add(self, i, j, r_ij, conservative, full):
        """A force on i from j; from r_i the line goes to r_i - r_ij."""
        super().add(i, j, r_ij, conservative, full)
        self.lines.append((self.position[:, i], r_ij, r_ij * conservative))

    def virial_in_slices(self, axis, edges):
        """(2, slices) array: along the axis, and the mean over the others."""
        found = np.zeros((2, len(edges) - 1))
        for begin, r_ij, virial in self.lines:
            shares = shares_of_slices(begin[axis], begin[axis] - r_ij[axis], edges)
            others = np.delete(virial, axis, axis=0).mean(axis=0)
            found += np.array([virial[axis], others]) @ shares
        return found


def shares_of_slices(begin, end, edges):
    """(lines, slices) array: the part of each line that lies in each slice, or an image of it."""
    low, high = np.minimum(begin, end)[:, None], np.maximum(begin, end)[:, None]
    length, period = high - low, edges[-1] - edges[0]
    shares = 0.0
    for image in (-period, 0.0, period):
        lower, upper = edges[:-1] + image, edges[1:] + image
        part = np.clip(np.minimum(high, upper) - np.maximum(low, lower), 0, None)
        inside = (low >= lower) & (low < upper)
        shares = shares + np.where(length > 1e-9, part / np.where(length > 0, length, 1), inside)
    return shares
