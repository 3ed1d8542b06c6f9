"""Friction that differs between species: what each pair, or each bead, has of it.

The terms of the physics have one friction, gamma. Where species differ, gamma is 1 and the shares
are the frictions themselves. What a term is given is multiplied by them before, so that scenes with
one friction run the code that they would run without this page.
"""

import numpy as np

from dpd.jit import part


@part()
def shares_of(term):
    """The shares of a thermostat; None where it is not there, or where all have one friction."""
    if term is None:
        return None
    return term.shares


@part()
def pair_share(shares, species, i, j):
    """The share of the pair in slots i and j."""
    if shares is None:
        return 1.0
    if species is None:
        return shares[0, 0]
    return shares[species[i], species[j]]


@part()
def share_friction(pairs, n, species, shares):
    """Multiply the approach of ``n`` pairs by their shares, and theta by the roots of those."""
    if shares is not None:
        for p in range(n):
            share = pair_share(shares, species, pairs.i[p], pairs.j[p])
            pairs.approach[p] *= share
            pairs.theta[p] *= np.sqrt(share)


@part()
def share_weights(pairs, n, species, shares):
    """Multiply w / r of ``n`` pairs, which stands in the place of theta, by the root of a share."""
    if shares is not None:
        for p in range(n):
            pairs.theta[p] *= np.sqrt(pair_share(shares, species, pairs.i[p], pairs.j[p]))


@part()
def bead_share(shares, species, s):
    """The share of the bead in slot s."""
    if species is None:
        return shares[0]
    return shares[species[s]]
