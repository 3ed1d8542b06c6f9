"""A plain NumPy engine: every pair of beads, one equation of Groot and Warren 1997 a line.

It shares nothing with the engine but the noise of a pair or of a bead. Beads are kept in the
order of their identities, and positions are not wrapped. Under shear velocities are those of the
laboratory: an image above moves with the flow there, and friction sees that.
"""

import copy

import numpy as np

from dpd.jit import kernel
from dpd.physics.common import noise
from dpd.physics.core import Core
from dpd.physics.pressure import draw

EXCHANGES = ("shardlow", "lowe-andersen", "aboba")
NOBODY = 0xFFFFFFFF  # less the number of an axis: whom a bead shares its Langevin noise with

fill_noise = kernel()(noise.fill_noise)
step_keys, pair_word = kernel()(noise.step_keys), kernel()(noise.pair_word)


def pair_noise(low, high, seed, step, gaussian):
    """The engine's own noise of pairs of identities at a step."""
    theta = np.empty(len(low))
    keys = noise.Keys(*map(np.uint32, step_keys(np.uint64(seed), step)))
    fill_noise(theta, low.astype(np.uint32), high.astype(np.uint32), len(low), keys, gaussian)
    return theta


def of_each(law):
    """Two parameters of a law for all, or of each bond or angle in a table."""
    one, other, number = law
    return (one, other) if number is None else (one[number], other[number])


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
        self.mass = 1.0 if system.masses is None else np.asarray(system.masses)[self.species]
        self.steps, self.at_walls = 0, None
        self.evaluate(self.velocity)

    def friction_of(self, *species):
        """gamma of a pair of species, or of a species."""
        gamma = np.asarray(self.system.friction, float)
        return gamma[species] if gamma.ndim else gamma

    def evaluate(self, velocity):
        """Forces, virials and energies where the beads are, friction with this velocity."""
        self.force = np.zeros_like(self.position)
        self.virial, self.energy = np.zeros((2, len(self.position), len(self.position))), [0, 0]
        self.virial_of_beads = np.zeros(self.position.shape[::-1] + self.position.shape[:1])
        self.evaluate_pairs(velocity)
        if self.system.per_bead:
            self.evaluate_bath(velocity)
        if self.system.walls is not None:
            self.evaluate_walls(velocity)
        if self.system.body_force is not None:
            self.evaluate_body_force()
        if self.system.bond is not None:
            self.evaluate_bonds()
        if self.system.angle is not None:
            self.evaluate_angles()

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
        apart = system.per_bead or self.scheme in EXCHANGES
        gamma = 0 if apart else self.friction_of(self.species[i], self.species[j])
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
        total = energy.sum()
        if system.many_body is not None:
            crowded, more = self.crowded(i, j, r)
            push, total = push + crowded, total + more
        conservative = push * e
        drag = -gamma * (1 - r) ** 2 * approach * e
        random = sigma * (1 - r) * zeta * system.dt**-0.5 * e
        self.energy[0] = total
        self.add(i, j, r_ij, conservative, conservative + drag + random)

    def crowded(self, i, j, r):
        """Warren 2003: B (rho_i + rho_j) (1 - r / r_d) of each pair, and the energy of all."""
        B, r_d, _ = self.system.many_body
        three, n, x = len(self.position) == 3, self.position.shape[1], np.maximum(0, 1 - r / r_d)
        w = (15 / (2 * np.pi * r_d**3) if three else 6 / (np.pi * r_d**2)) * x**2
        rho = np.bincount(i, w, n) + np.bincount(j, w, n)
        c = np.pi * r_d**4 * B / 30 if three else np.pi * r_d**3 * B / 24
        return B * (rho[i] + rho[j]) * x, c * (rho**2).sum()

    def evaluate_bath(self, velocity):
        """Langevin: -gamma v + sigma zeta dt^(-1/2) along each axis; no part of the virial."""
        system, beads = self.system, np.arange(velocity.shape[1])
        gamma = self.friction_of(self.species)
        sigma = np.sqrt(2 * gamma * system.kT)
        velocity = velocity - flow_of(system, self.position)
        for axis in range(len(velocity)):
            partner = np.full(len(beads), NOBODY - axis)
            zeta = pair_noise(beads, partner, system.seed, self.steps, system.gaussian)
            drag = -gamma * velocity[axis]
            self.force[axis] += drag + sigma * zeta * system.dt**-0.5

    def evaluate_walls(self, velocity):
        """Planes: a_w (1 - z) along their normal; friction and noise in all directions."""
        system, walls, beads = self.system, self.system.walls, np.arange(velocity.shape[1])
        gamma, a = system.wall_friction, walls.repulsion[self.species]
        sigma = np.sqrt(2 * gamma * system.kT)
        self.at_walls = np.zeros((len(walls.axis), 2 + len(velocity)))
        planes = zip(walls.axis, walls.inward, walls.place, walls.velocity)
        for number, (axis, inward, place, moving) in enumerate(planes):
            z = inward * (self.position[axis] - place)
            near, w = z < 1, np.clip(1 - z, 0, 1)
            push = np.where(near, a * (1 - z), 0)
            self.force[axis] += inward * push
            self.at_walls[number, :2] = (near * a * (1 - z) ** 2 / 2).sum(), push.sum()
            for k in range(len(velocity)):
                partner = np.full(len(beads), NOBODY - 3 - 3 * number - k)
                zeta = pair_noise(beads, partner, system.seed, self.steps, system.gaussian)
                drag = -gamma * w**2 * (velocity[k] - moving[k])
                drag += sigma * w * zeta * system.dt**-0.5
                self.force[k] += drag
                self.at_walls[number, 2 + k] = drag.sum()

    def evaluate_body_force(self):
        """A constant force, the other way round in the upper half of the axis across."""
        body = self.system.body_force
        x = self.position[body.across] % self.system.box[body.across]
        sign = np.where(x < body.middle, 1, -1)
        self.force[body.axis] += sign * body.strength[self.species]

    def evaluate_bonds(self):
        """Springs: energy C (r - length)^2 / 2."""
        stiffness, length = of_each(self.system.bond)
        i, j = self.system.members.T
        r_ij, r, e = self.separation(i, j)
        pull = -stiffness * (r - length) * e
        self.energy[1] = (stiffness * (r - length) ** 2 / 2).sum()
        self.add(i, j, r_ij, pull, pull)

    def evaluate_angles(self):
        """Angles: energy k (theta - theta_0)^2 / 2, theta from the cosine of both bonds."""
        stiffness, rest = of_each(self.system.angle)
        i, j, k = self.system.angle_members.T
        r_ij, length_i, e_i = self.separation(i, j)
        r_kj, length_k, e_k = self.separation(k, j)
        cosine = (e_i * e_k).sum(axis=0)
        theta = np.arccos(np.clip(cosine, -1, 1))
        slope = stiffness * (theta - rest) / np.sin(theta)
        on_i = slope * (e_k - cosine * e_i) / length_i
        on_k = slope * (e_i - cosine * e_k) / length_k
        self.energy[1] += (stiffness * (theta - rest) ** 2 / 2).sum()
        self.add(i, j, r_ij, on_i, on_i)
        self.add(k, j, r_kj, on_k, on_k)

    def add(self, i, j, r_ij, conservative, full):
        """Add a force on i from j, and the virials sum r_ij F_ij."""
        for k in range(len(self.force)):
            np.add.at(self.force[k], i, full[k])
            np.subtract.at(self.force[k], j, full[k])
        self.virial += [r_ij @ conservative.T, r_ij @ full.T]
        for ends in (i, j):
            half = r_ij[:, None] * conservative / 2
            np.add.at(self.virial_of_beads, ends, half.transpose(2, 0, 1))

    def step(self):
        """One step of Eq. 7 or Eq. 9, with or without an acceleration term, or of DPD-VV.

        Or of a scheme that ends with an exchange of momentum, or has it in its middle.
        """
        dt, v, f = self.system.dt, self.velocity, self.force / self.mass
        self.steps += 1
        if self.scheme == "aboba":
            self.position = self.position + dt * v / 2
            self.evaluate(v)
            self.velocity = v + dt * self.force / self.mass / 2
            self.exchange()
            self.velocity += dt * self.force / self.mass / 2
            self.position = self.position + dt * self.velocity / 2
        elif self.scheme in ("euler", "euler-acceleration"):
            acceleration = 0 if self.scheme == "euler" else dt**2 * f / 2
            self.position = self.position + dt * v + acceleration
            self.velocity = v + dt * f
            self.evaluate(self.velocity)
        else:
            acceleration = 0 if self.scheme == "verlet-no-acceleration" else dt**2 * f / 2
            self.position = self.position + dt * v + acceleration
            self.evaluate(v + self.prediction * dt * f)
            self.velocity = v + dt * (f + self.force / self.mass) / 2
        if self.scheme in ("shardlow", "lowe-andersen"):
            self.exchange()
        if self.scheme == "dpd-vv":
            # The same place and noise, friction of the final velocities; the virial stays.
            kept = self.virial, self.energy, self.at_walls
            self.evaluate(self.velocity)
            self.virial, self.energy, self.at_walls = kept

    def exchange(self):
        """Let pairs exchange momentum along their lines, in the order of their identities.

        Shardlow's two half steps, as Nikunen et al. 2003 write them; the exact solution of the
        Ornstein-Uhlenbeck process of the pair; or Lowe's new relative velocity.
        """
        system, dt, kT = self.system, self.system.dt, self.system.kT
        i, j = np.triu_indices(self.position.shape[1], 1)
        near = self.separation(i, j)[1] < 1
        i, j = i[near], j[near]
        _, r, e = self.separation(i, j)
        gamma = np.broadcast_to(self.friction_of(self.species[i], self.species[j]), r.shape)
        gaussian = system.gaussian or self.scheme != "shardlow"
        zeta = pair_noise(i, j, system.seed, self.steps, gaussian)
        mass = np.broadcast_to(self.mass, self.velocity.shape[1])
        inverse_mu = 1 / mass[i] + 1 / mass[j]
        for p in range(len(r)):
            one, two = i[p], j[p]
            u = e[:, p] @ (self.velocity[:, one] - self.velocity[:, two])
            g, per_mu = gamma[p] * (1 - r[p]) ** 2, inverse_mu[p]
            if self.scheme == "lowe-andersen":
                drawn = self.chance(one, two) < gamma[p] * dt
                new = np.sqrt(kT * per_mu) * zeta[p] if drawn else u
            elif self.scheme == "aboba":
                decay = np.exp(-g * dt * per_mu)
                new = u * decay + np.sqrt(kT * per_mu * (1 - decay**2)) * zeta[p]
            else:
                push = np.sqrt(2 * g * kT) * zeta[p] * np.sqrt(dt) / 2
                half = u + (push - g * u * dt / 2) * per_mu
                new = (half + push * per_mu) / (1 + g * dt * per_mu / 2)
            momentum = (new - u) / per_mu
            self.velocity[:, one] += momentum / mass[one] * e[:, p]
            self.velocity[:, two] -= momentum / mass[two] * e[:, p]

    def chance(self, low, high):
        """The engine's number from 0 to 1 of a pair at this step."""
        first, second = step_keys(np.uint64(self.system.seed), self.steps)
        keys = noise.Keys(np.uint32(second), np.uint32(first))
        return pair_word(np.uint32(low), np.uint32(high), keys) / 2**32


class PressedReference(Reference):
    """The same at constant pressure, as Bernetti and Bussi 2020 write it, in sqrt(V).

    It shares the random numbers of a trial with the engine, and no formula.
    """

    def __init__(self, system, *arguments):
        self.accepted = self.tried = 0
        super().__init__(copy.copy(system), *arguments)

    def step(self):
        """A step, and where one is due, a trial of another volume."""
        super().step()
        if self.steps % self.system.pressure.every == 0:
            self.rescale()

    def rescale(self):
        """Propose sqrt(V) by an Euler step, and take it as Metropolis and Hastings do."""
        law, system = self.system.pressure, self.system
        now = np.sqrt(np.prod(system.box))
        normal, chance = draw(system.seed, self.steps)
        kept = copy.copy(vars(self))
        step = law.every * system.dt
        variance = system.kT * law.compressibility / (2 * law.time) * step
        mean = now + self.drift(step)
        energy = self.enthalpy()
        new = mean + np.sqrt(variance) * normal
        self.stretch(new**2 / now**2)
        mean_back = new + self.drift(step)
        # Densities of sqrt(V) in equilibrium, and of the proposals there and back.
        here = now * np.exp(-(energy - self.enthalpy()) / system.kT)
        forth = np.exp(-((new - mean) ** 2) / (2 * variance))
        back = np.exp(-((now - mean_back) ** 2) / (2 * variance))
        self.tried += 1
        if chance < new * back / (here * forth):
            self.accepted += 1
        else:
            vars(self).update({name: kept[name] for name in kept if name != "tried"})

    def drift(self, step):
        """Change of sqrt(V) without noise; the volume changes by a tenth at most."""
        law, volume, kT = self.system.pressure, np.prod(self.system.box), self.system.kT
        push = self.pressure() - law.target + kT / (2 * volume)
        rate = law.compressibility * np.sqrt(volume) / (2 * law.time) * push
        most = 0.05 * np.sqrt(volume)
        return np.clip(rate * step, -most, most)

    def pressure(self):
        """Mean over the stretched axes of (sum v v + conservative virial) / V; see `enthalpy`."""
        each = [
            (self.velocity[k] @ self.velocity[k] + self.virial[0][k, k])
            for k in self.system.pressure.axes
        ]
        return (np.mean(each) + self.kept_momentum()) / np.prod(self.system.box)

    def enthalpy(self):
        """Kinetic and potential energy, and P_0 V; kT ln V less where momentum is conserved."""
        volume = np.prod(self.system.box)
        held = self.system.pressure.target * volume - self.kept_momentum() * np.log(volume)
        return (self.velocity**2).sum() / 2 + np.sum(self.energy) + held

    def kept_momentum(self):
        """kT, or 0 in a bath that takes momentum."""
        return 0.0 if self.system.per_bead else self.system.kT

    def stretch(self, times):
        """Stretch the box to so many times its volume."""
        axes = list(self.system.pressure.axes)
        factor = np.ones((len(self.position), 1))
        factor[axes] = times ** (1 / len(axes))
        self.position, self.velocity = self.position * factor, self.velocity / factor
        self.system = copy.copy(self.system)
        object.__setattr__(self.system, "box", tuple(np.array(self.system.box) * factor[:, 0]))
        self.evaluate(self.velocity)
