"""A plain NumPy engine: every pair of beads, one equation of Groot and Warren 1997 a line.

It shares nothing with the engine but the noise of a pair or of a bead. Beads are kept in the
order of their identities, and positions are not wrapped. Under shear velocities are those of the
laboratory: an image above moves with the flow there, and friction sees that.
"""

import numpy as np

from dpd.jit import kernel
from dpd.physics import noise
from dpd.physics.core import Core

NOBODY = 0xFFFFFFFF  # less the number of an axis: whom a bead shares its Langevin noise with

uniform_noise, gaussian_noise = kernel()(noise.uniform_noise), kernel()(noise.gaussian_noise)
step_keys, pair_word = kernel()(noise.step_keys), kernel()(noise.pair_word)
mix32, minus_log, cos_pi = map(kernel(), (noise.mix32, noise.minus_log, noise.cos_pi))


def pair_noise(low, high, seed, step, gaussian):
    """The engine's own noise of pairs of identities at a step."""
    theta = np.empty(len(low))
    fill = gaussian_noise if gaussian else uniform_noise
    keys = noise.Keys(*map(np.uint32, step_keys(np.uint64(seed), step)))
    fill(theta, low.astype(np.uint32), high.astype(np.uint32), len(low), keys)
    return theta


def flow_of(system, position):
    """Velocity of the flow where beads are."""
    flow = np.zeros_like(position)
    if system.shear is not None:
        flow[system.shear.flow] = system.shear.rate * position[system.shear.gradient]
    return flow


class Reference:
    """A `System` moved by a scheme of the paper, named, with its lambda."""

    def __init__(self, system, scheme, prediction, position, velocity, species=None):
        self.system, self.scheme, self.prediction = system, scheme, prediction
        self.position, self.velocity = position.copy(), velocity + flow_of(system, position)
        self.species = np.zeros(position.shape[1], int) if species is None else species
        self.steps = 0
        self.evaluate(self.velocity)

    def evaluate(self, velocity):
        """Forces, virials and energies where the beads are, friction with this velocity."""
        self.force = np.zeros_like(self.position)
        self.virial, self.energy = np.zeros((2, len(self.position), len(self.position))), [0, 0]
        self.evaluate_pairs(velocity)
        if self.system.per_bead:
            self.evaluate_bath(velocity)
        if self.system.bond is not None:
            self.evaluate_bonds()

    def separation(self, i, j):
        """r_ij at the nearest image, r, and the unit vector e."""
        box = np.array(self.system.box)[:, None]
        r_ij = self.position[:, i] - self.position[:, j] - self.slid(i, j)
        r_ij = r_ij - box * np.round(r_ij / box)
        r = np.sqrt((r_ij**2).sum(axis=0))
        return r_ij, r, r_ij / r

    def slid(self, i, j):
        """How far the image of j that is nearest to i along the gradient has slid, as a vector."""
        return self.faster(i, j) * self.system.dt * self.steps

    def faster(self, i, j):
        """How much faster that image of j is than j."""
        shear, box = self.system.shear, self.system.box
        difference = np.zeros((len(box), len(i)))
        if shear is not None:
            height = box[shear.gradient]
            apart = self.position[shear.gradient, i] - self.position[shear.gradient, j]
            difference[shear.flow] = shear.rate * height * np.round(apart / height)
        return difference

    def evaluate_pairs(self, velocity):
        """Eqs. 3 to 6 and 8; with a core, Liu et al. 2008, Eq. 5."""
        system = self.system
        i, j = np.triu_indices(self.position.shape[1], 1)
        near = self.separation(i, j)[1] < 1
        i, j = i[near], j[near]
        r_ij, r, e = self.separation(i, j)
        a = system.pair.repulsion[self.species[i], self.species[j]]
        gamma = 0 if system.per_bead else system.friction
        sigma = np.sqrt(2 * gamma * system.kT)
        zeta = pair_noise(i, j, system.seed, self.steps, system.gaussian)
        v_ij = velocity[:, i] - velocity[:, j] - self.faster(i, j)
        approach = (e * v_ij).sum(axis=0)
        push, energy = a * (1 - r), a * (1 - r) ** 2 / 2
        if isinstance(system.pair, Core):
            _, d, most, width = system.pair
            width = width or 0.0
            outer = a * (1 - d - width)
            beyond = a * (1 - d - width) ** 2 / 2
            ramp = outer + (most - outer) * (d + width - r) / (width or 1.0)
            edge = (r >= d) & (r < d + width)
            energy = np.where(edge, (ramp + outer) * (d + width - r) / 2 + beyond, energy)
            push = np.where(edge, ramp, push)
            energy = np.where(r < d, most * (d - r) + (most + outer) * width / 2 + beyond, energy)
            push = np.where(r < d, most, push)
        conservative = push * e
        drag = -gamma * (1 - r) ** 2 * approach * e
        random = sigma * (1 - r) * zeta * system.dt**-0.5 * e
        self.energy[0] = energy.sum()
        self.add(i, j, r_ij, conservative, conservative + drag + random)

    def evaluate_bath(self, velocity):
        """Langevin: -gamma v + sigma zeta dt^(-1/2) along each axis; no part of the virial."""
        system, beads = self.system, np.arange(velocity.shape[1])
        sigma = np.sqrt(2 * system.friction * system.kT)
        velocity = velocity - flow_of(system, self.position)
        for axis in range(len(velocity)):
            partner = np.full(len(beads), NOBODY - axis)
            zeta = pair_noise(beads, partner, system.seed, self.steps, system.gaussian)
            drag = -system.friction * velocity[axis]
            self.force[axis] += drag + sigma * zeta * system.dt**-0.5

    def evaluate_bonds(self):
        """Springs: energy C (r - length)^2 / 2."""
        stiffness, length = self.system.bond
        i, j = self.system.members.T
        r_ij, r, e = self.separation(i, j)
        pull = -stiffness * (r - length) * e
        self.energy[1] = (stiffness * (r - length) ** 2 / 2).sum()
        self.add(i, j, r_ij, pull, pull)

    def add(self, i, j, r_ij, conservative, full):
        """Add a force on i from j, and the virials sum r_ij F_ij."""
        for k in range(len(self.force)):
            np.add.at(self.force[k], i, full[k])
            np.subtract.at(self.force[k], j, full[k])
        self.virial += [r_ij @ conservative.T, r_ij @ full.T]

    def step(self):
        """One step of Eq. 7, of Eq. 9 with or without its acceleration term, or of DPD-VV."""
        dt, v, f = self.system.dt, self.velocity, self.force
        self.steps += 1
        if self.scheme == "euler":
            self.position = self.position + dt * v
            self.velocity = v + dt * f
            self.evaluate(self.velocity)
        else:
            acceleration = 0 if self.scheme == "verlet-no-acceleration" else dt**2 * f / 2
            self.position = self.position + dt * v + acceleration
            self.evaluate(v + self.prediction * dt * f)
            self.velocity = v + dt * (f + self.force) / 2
        if self.scheme == "dpd-vv":
            # The same place and noise, friction of the final velocities; the virial stays.
            kept = self.virial, self.energy
            self.evaluate(self.velocity)
            self.virial, self.energy = kept
