"""Mean lengths of harmonic bonds, alone and in a fluid."""

import numpy as np
import pytest

from paper_figures.crgw_2019.bonds import mean_length, rest_length


def test_a_bond_without_repulsion():
    """Rest length 0: the mean of a Maxwell distribution, sqrt(8 / (pi C))."""
    assert mean_length(4, 0) == pytest.approx(np.sqrt(8 / (np.pi * 4)), rel=1e-6)


def test_the_soft_repulsion_is_a_second_spring():
    """Below r_c both are harmonic: one spring with the sum of the stiffnesses, and its mean."""
    stiffness, rest, a = 400.0, 0.3, 40.0
    both = (stiffness * rest + a) / (stiffness + a)
    assert mean_length(stiffness, rest, a) == pytest.approx(
        mean_length(stiffness + a, both), rel=1e-6
    )


def test_a_fluid_pushes_beads_together():
    """The denser, the shorter; of beads at density 0 it is the limit."""
    lengths = [mean_length(200, 0.3, 25, density) for density in (0, 1e-4, 3, 7)]
    assert lengths[1] == pytest.approx(lengths[0], abs=1e-5)
    assert lengths[0] > lengths[2] > lengths[3]


@pytest.mark.parametrize("density", [0, 5])
def test_there_and_back(density):
    """The rest length gives the mean that was asked for."""
    rest = rest_length(500, 25, 0.4, density)
    assert mean_length(500, rest, 25, density) == pytest.approx(0.4, rel=1e-9)


def test_the_rest_of_a_chain_pushes_a_bond_apart():
    """Means of runs of 240 beads with these rest lengths: 0.308 for m = 4, 0.318 for m = 8."""
    for beads, mean in ((2, 0.283), (4, 0.308), (8, 0.318)):
        assert rest_length(1000, 40, mean, 3, beads) == pytest.approx(0.26, abs=0.004)
    alone, far = rest_length(1000, 40, 0.6, 3), rest_length(1000, 40, 0.6, 3, 8)
    assert far == pytest.approx(alone, abs=4e-3)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((0.001, 25, 0.4, 3), "bond length: with a stiffness of 0.001 .* beyond the grid"),
        ((10, 40, 0.3), "needs a rest length below 0; allowed: 0.8"),
    ],
)
def test_what_cannot_be(arguments, said):
    """With name, value, and what is allowed."""
    with pytest.raises(ValueError, match=said):
        rest_length(*arguments)
