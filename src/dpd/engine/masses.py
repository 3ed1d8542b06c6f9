"""Masses of species.

Kernels move beads by the array of forces as if all masses were 1. In a scene with masses each row
of that array is divided by the mass of its bead once all forces are added up. From then on it holds
accelerations. Other scenes have none of this code.
"""

from dpd.jit import part


@part()
def inverse_of(inverse_mass, species, s):
    """1 / m of the bead in slot s."""
    if species is None:
        return inverse_mass[0]
    return inverse_mass[species[s]]


@part()
def divide_by_masses(force, species, mine, inverse_mass):
    """Turn the forces on a thread's share of the beads into accelerations, if there are masses.

    Parameters
    ----------
    force : array with a row for each bead
    species : None or (n,) array
    mine : Share
    inverse_mass : None or (species,) array
    """
    if inverse_mass is not None:
        for i in range(mine.first, mine.end):
            inverse = inverse_of(inverse_mass, species, i)
            for k in range(force.shape[1]):
                force[i, k] *= inverse


@part()
def multiply_by_masses(force, species, mine, inverse_mass):
    """Turn the accelerations back into forces, so that more forces can be added."""
    if inverse_mass is not None:
        for i in range(mine.first, mine.end):
            mass = 1.0 / inverse_of(inverse_mass, species, i)
            for k in range(force.shape[1]):
                force[i, k] *= mass


@part()
def push_masses_apart(velocity, i, j, momentum, inverse_i, inverse_j, along, p):
    """Give bead i that momentum times column p of ``along``, and bead j the opposite."""
    for k in range(along.shape[0]):
        gained = momentum * along[k, p]
        velocity[i, k] += inverse_i * gained
        velocity[j, k] -= inverse_j * gained
