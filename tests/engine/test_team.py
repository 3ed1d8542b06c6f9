"""Threads that share the work: the same bits for any number of them."""

import copy
from itertools import pairwise

import numpy as np
import pytest

from dpd.engine.space import PHASES, make_blocks
from dpd.engine.threads import BLOCKS, LINE
from dpd.errors import LostRun, UserError
from tests.systems import assert_same_state, chains, make_simulation, make_system, random_beads

BONDS = (chains(40, 30), 50.0, 0.5)
CASES = {
    "five layers": dict(box=(5.1, 4.2, 4.4)),
    "blocks within layers": dict(box=(3.2, 9.4, 2.2)),
    "four blocks in a layer": dict(box=(3.2, 17.4, 1.1)),
    "deep blocks": dict(box=(32.2, 16.4, 1.1), beads=1500),
    "deep blocks in 2D, with a list": dict(box=(130.1, 6.2), beads=1500, skin=0.2, dt=0.002),
    "more beads than a drift takes at once": dict(box=(14.1, 14.2, 15.0), beads=9000),
    "one layer": dict(box=(1.9, 6.0, 6.0)),
    "friction twice, with bonds": dict(box=(5.1, 6.2, 7.4), scheme="dpd-vv", bonds=BONDS, dt=0.01),
    "list with bonds": dict(box=(30.1, 20.2), bonds=BONDS, skin=0.2, dt=0.002),
}


def outcome(threads, box, beads=None, **changes):
    """State and sums after 15 steps, in two calls."""
    beads = beads or (1200 if "bonds" in changes else 300)
    start = random_beads(box, beads, seed=3)
    simulation = make_simulation(make_system(box, **changes), *start, threads=threads)
    simulation.advance(7)
    return simulation.state, simulation.sample(8, [15], measure=True).of(-1)


@pytest.mark.few(2)
@pytest.mark.parametrize("scheme", ["gw-vv", "dpd-vv"])
@pytest.mark.parametrize("threads", [1, 2, 4])
def test_a_call_that_is_short_of_room_is_made_again(scheme, threads):
    """Beads fall together, so that buffers overflow in mid-run: to the same bits."""
    system = make_system((6.0, 6.0, 6.0), scheme, dt=0.002, skin=0.25)
    position, velocity = random_beads(system.box, 300, seed=5)
    velocity = -4.0 * (position - 3.0)
    one, other = (
        make_simulation(system, position, velocity, threads=each) for each in (threads, 1)
    )
    other._room[:] = 60_000
    other._make_buffers()
    first = one._room.copy()
    before, kept = one.state, copy.deepcopy(one.state)
    sums, expected = (each.sample(120, [120], measure=True).of(-1) for each in (one, other))
    assert (one._room[:2] > first[:2]).all() and (one._room < 60_000).all()
    assert_same_state(one.state, other.state)
    assert_same_state(before, kept)
    np.testing.assert_array_equal(one.state.image, other.state.image)
    np.testing.assert_array_equal(sums.virial, expected.virial)


@pytest.mark.few("five layers", "deep blocks", "friction twice, with bonds")
@pytest.mark.parametrize("case", CASES)
def test_threads_do_not_change_a_bit(case):
    one, one_sums = outcome(1, **CASES[case])
    for threads in (2, 3):
        state, sums = outcome(threads, **CASES[case])
        assert_same_state(state, one)
        np.testing.assert_array_equal(sums.virial, one_sums.virial)
        np.testing.assert_array_equal(sums.energy, one_sums.energy)


def rows_of_block(blocks, block):
    """Numbers of the rows of a block."""
    pieces = blocks.rows[blocks.piece[block] : blocks.piece[block + 1]]
    return [row for piece in pieces for row in range(*piece)]


def rows_pushed(own, layers, rows):
    """Rows (layer, place) with beads that the pairs of some rows push."""
    pushed = set()
    for row in own:
        layer, place = divmod(row, rows)
        pushed |= {(layer, place), (layer, (place + 1) % rows)}
        pushed |= {((layer + 1) % layers, (place + step) % rows) for step in (-1, 0, 1)}
    return pushed


@pytest.mark.parametrize("rows", [1, 2, 3, 7, 8, 9, 15, 16, 17, 21, 40])
@pytest.mark.parametrize("layers", [*range(1, 12), 31, 32, 33, 69, 129, 200])
def test_blocks_of_a_phase_push_no_bead_in_common(layers, rows):
    blocks = make_blocks(layers, rows)
    assert len(blocks.phase) <= PHASES + 1
    assert BLOCKS + PHASES <= LINE  # a thread's counters of tasks
    for begin, end in pairwise(blocks.phase):
        assert end > begin
        pushed = [rows_pushed(rows_of_block(blocks, b), layers, rows) for b in range(begin, end)]
        assert sum(map(len, pushed)) == len(set.union(*pushed))
    met = [row for b in range(blocks.phase[-1]) for row in rows_of_block(blocks, b)]
    assert sorted(met) == list(range(layers * rows))


def test_blown_up_run_ends_for_all_threads():
    system = make_system((6.0, 5.0, 5.0), repulsion=np.array([[1e6]]), dt=0.1)
    position, velocity = random_beads(system.box, 300)
    problems = []
    for threads in (1, 3):
        simulation = make_simulation(system, position, velocity, threads=threads)
        with pytest.raises(LostRun) as caught:
            simulation.advance(50)
        problems.append((str(caught.value), caught.value.step))
    assert problems[0] == problems[1]


def test_exchange_of_momentum_asks_for_one_thread():
    system = make_system((4.0, 4.0, 4.0), scheme="shardlow")
    with pytest.raises(UserError, match="one thread"):
        make_simulation(system, *random_beads(system.box, 50), threads=2)
