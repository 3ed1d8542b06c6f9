"""Arrays with a row for each bead, what kernels do with rows, nearest images, values by species.

Numba leaves out the pass of LLVM that joins the entries of a row into a vector, so what loads and
stores a row at once is written out in LLVM's own instructions, with what runs under
NUMBA_DISABLE_JIT=1 before it.
"""

import math
from functools import partial
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.np.arrayobj import populate_array

from dpd.jit import FEATURES, WIDE, inlined, intrinsic_for

CACHE_LINE, HALF = 64, 32  # bytes: the registers of AVX-512, and of AVX2
PERMUTES = "+avx2" in FEATURES and not WIDE
LANES = 16  # entries that instructions for searches take at a time
FOUR = 4  # pairs whose rows are turned into columns together


def rows_of(array: np.ndarray) -> np.ndarray:
    """A (dimension, n) array as kernels take it: a row for each bead.

    Pairs push beads that lie anywhere in memory. A row, padded with zeros to a width that
    processors load and store at once, is one access, where three arrays would be three.
    """
    dimension, beads = array.shape
    rows = aligned((beads, row_width(dimension)))
    for k in range(dimension):  # twice as fast as all at once
        rows[:, k] = array[k]
    rows[:, dimension:] = 0.0
    return rows


def aligned(shape: tuple[int, ...], kind: Any = np.float64) -> np.ndarray:
    """An array that begins where a line of the cache does: of narrow rows, none lies in two."""
    size, width = math.prod(shape), np.dtype(kind).itemsize
    memory = np.empty(size + CACHE_LINE // width, kind)
    first = -memory.ctypes.data % CACHE_LINE // width
    return memory[first : first + size].reshape(shape)


def axes_of(rows: np.ndarray, dimension: int) -> np.ndarray:
    """The (dimension, n) view of what `rows_of` made."""
    return rows[:, :dimension].T


def row_width(dimension: int) -> int:
    """Numbers in a row: a power of two."""
    return 2 if dimension < 3 else 4


def _row_vector(edges):
    return ir.VectorType(ir.DoubleType(), row_width(len(edges)))


def _row(context, builder, array_type, array, i, vector):
    """Pointer to row i as a vector."""
    rows = context.make_array(array_type)(context, builder, array)
    i = builder.zext(i, ir.IntType(64)) if i.type.width < 64 else i
    return builder.gep(builder.bitcast(rows.data, vector.as_pointer()), [i])


def _column(context, builder, array_type, array, p, dimension):
    """Pointers to the entries of column p."""
    columns = context.make_array(array_type)(context, builder, array)
    places = ([ir.Constant(p.type, k), p] for k in range(dimension))
    return [
        cgutils.get_item_pointer(context, builder, array_type, columns, place) for place in places
    ]


@intrinsic_for(lambda rows: rows.reshape(-1))
def flat(typing, rows):
    """All entries of an array of rows, one after the other."""
    one_axis = types.Array(rows.dtype, 1, "C")

    def code(context, builder, signature, arguments):
        given = context.make_array(rows)(context, builder, arguments[0])
        made = context.make_array(one_axis)(context, builder)
        populate_array(
            made, given.data, [given.nitems], [given.itemsize], given.itemsize, given.meminfo
        )
        if context.enable_nrt:
            context.nrt.incref(builder, one_axis, made._getvalue())
        return made._getvalue()

    return one_axis(rows), code


def _copy_row(target, s, source, i, edges):
    target[s] = source[i]


@intrinsic_for(_copy_row)
def copy_row(typing, target, s, source, i, edges):
    vector = _row_vector(edges)

    def code(context, builder, signature, arguments):
        target_array, s, source_array, i, _ = arguments
        to = _row(context, builder, target, target_array, s, vector)
        at = _row(context, builder, source, source_array, i, vector)
        builder.store(builder.load(at, align=8), to, align=8)
        return context.get_dummy_value()

    return types.none(target, s, source, i, edges), code


FOUR_NUMBERS = ir.VectorType(ir.DoubleType(), FOUR)


def _four_rows(context, builder, edges, kind, array, places, places_array, p):
    """Of an array, the rows that four entries of ``places`` tell, from p on."""
    made = context.make_array(places)(context, builder, places_array)
    for q in range(FOUR):
        at = builder.gep(made.data, [builder.add(p, ir.Constant(p.type, q))])
        row = _row(context, builder, kind, array, builder.load(at), _row_vector(edges))
        yield builder.load(row, align=8)


def _columns_apart(context, builder, edges, ours, theirs):
    """The columns of four rows minus four others."""
    apart = list(map(builder.fsub, ours, theirs))
    for k in range(len(edges)):
        column = ir.Constant(FOUR_NUMBERS, ir.Undefined)
        for q in range(FOUR):
            number = builder.extract_element(apart[q], cgutils.int32_t(k))
            column = builder.insert_element(column, number, cgutils.int32_t(q))
        yield column


def _apart_to_columns(target, p, x, i, j, edges, move, m):
    for q in range(int(p), int(p) + FOUR):
        for k in range(len(edges)):
            target[k, q] = x[i[q], k] - (x[j[q], k] + (0.0 if move is None else move[m[q], k]))


@intrinsic_for(_apart_to_columns)
def apart_to_columns(typing, target, p, x, i, j, edges, move, m):
    """Make rows i minus rows j, these moved by rows m, columns p to p + 3 of ``target``.

    i, j and m are arrays, read from p on. Four at a time, as that takes fewer instructions than
    entry by entry.
    """

    def code(context, builder, signature, arguments):
        to, p, rows, i_array, j_array, _, move_array, m_array = arguments
        chosen = partial(_four_rows, context, builder, edges, p=p)
        theirs = chosen(x, rows, j, j_array)
        if move is not types.none:
            theirs = map(builder.fadd, theirs, chosen(move, move_array, m, m_array))
        apart = _columns_apart(context, builder, edges, chosen(x, rows, i, i_array), theirs)
        for column, entry in zip(apart, _column(context, builder, target, to, p, len(edges))):
            builder.store(column, builder.bitcast(entry, FOUR_NUMBERS.as_pointer()), align=8)
        return context.get_dummy_value()

    return types.none(target, p, x, i, j, edges, move, m), code


def _differences_along(target, p, rows, i, j, along, edges):
    for q in range(int(p), int(p) + FOUR):
        target[q] = difference_along(rows, i[q], j[q], along, q, edges)


@intrinsic_for(_differences_along)
def differences_along(typing, target, p, rows, i, j, along, edges):
    """Make `difference_along` of four pairs entries p to p + 3 of ``target``."""

    def code(context, builder, signature, arguments):
        to, p, array, i_array, j_array, along_array, _ = arguments
        chosen = partial(_four_rows, context, builder, edges, rows, array, p=p)
        apart = _columns_apart(context, builder, edges, chosen(i, i_array), chosen(j, j_array))
        total = ir.Constant(FOUR_NUMBERS, [0.0] * FOUR)
        for column, entry in zip(
            apart, _column(context, builder, along, along_array, p, len(edges))
        ):
            other = builder.load(builder.bitcast(entry, FOUR_NUMBERS.as_pointer()), align=8)
            product = builder.fmul(column, other, flags=["contract"])
            total = builder.fadd(total, product, flags=["contract", "nsz"])
        made = context.make_array(target)(context, builder, to)
        at = builder.bitcast(builder.gep(made.data, [p]), FOUR_NUMBERS.as_pointer())
        builder.store(total, at, align=8)
        return context.get_dummy_value()

    return types.none(target, p, rows, i, j, along, edges), code


@inlined()
def difference_along(rows, i, j, along, p, edges):
    """Scalar product of row i minus row j and column p of ``along``."""
    total = 0.0
    for k in range(len(edges)):
        total += (rows[i, k] - rows[j, k]) * along[k, p]
    return total


def _push_apart(force, i, j, scale, along, p, edges):
    for k in range(len(edges)):
        force[i, k] += scale * along[k, p]
        force[j, k] -= scale * along[k, p]


@intrinsic_for(_push_apart)
def push_apart(typing, force, i, j, scale, along, p, edges):
    """Add scale times column p of ``along`` to row i, and take the same off row j."""
    vector = _row_vector(edges)

    def code(context, builder, signature, arguments):
        array, i, j, scale, along_array, p, _ = arguments
        push = ir.Constant(vector, [0.0] * vector.count)
        column = _column(context, builder, along, along_array, p, len(edges))
        for k, entry in enumerate(column):
            component = builder.fmul(scale, builder.load(entry))
            push = builder.insert_element(push, component, cgutils.int32_t(k))
        for place, change in ((i, builder.fadd), (j, builder.fsub)):
            row = _row(context, builder, force, array, place, vector)
            builder.store(change(builder.load(row, align=8), push), row, align=8)
        return context.get_dummy_value()

    return types.none(force, i, j, scale, along, p, edges), code


@intrinsic_for(lambda word: np.uint64(int(word).bit_count()))
def popcount(typing, word):
    def code(context, builder, signature, arguments):
        return builder.ctpop(arguments[0])

    return word(word), code


@intrinsic_for(lambda word: np.uint64((int(word) & -int(word)).bit_length() - 1 if word else 64))
def lowest(typing, word):
    """Place of the lowest bit that is set; 64 if none is."""

    def code(context, builder, signature, arguments):
        return builder.cttz(arguments[0], ir.Constant(ir.IntType(1), 0))

    return word(word), code


def _lanes(context, builder, array_type, array, first):
    """Pointer to `LANES` entries of an array with one axis as a vector."""
    made = context.make_array(array_type)(context, builder, array)
    vector = ir.VectorType(context.get_data_type(array_type.dtype), LANES)
    return builder.bitcast(builder.gep(made.data, [first]), vector.as_pointer())


def _all_lanes(builder, value):
    free = ir.Constant(ir.VectorType(value.type, LANES), ir.Undefined)
    one = builder.insert_element(free, value, cgutils.int32_t(0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
    return builder.shuffle_vector(one, free, zeros)


def _copy_lanes(target, to, source, first, by):
    to, first = int(to), int(first)
    target[to : to + LANES] = source[first : first + LANES] + by


@intrinsic_for(_copy_lanes)
def copy_lanes(typing, target, to, source, first, by):
    """Copy `LANES` numbers, and add ``by`` to each."""

    def code(context, builder, signature, arguments):
        there, to, given, first, by = arguments
        entries = builder.load(_lanes(context, builder, source, given, first), align=4)
        moved = builder.fadd(entries, _all_lanes(builder, by))
        builder.store(moved, _lanes(context, builder, target, there, to), align=4)
        return context.get_dummy_value()

    return types.none(target, to, source, first, source.dtype), code


def _count_lanes(target, to, value, step):
    to = int(to)
    target[to : to + LANES] = np.arange(LANES, dtype=np.uint32) * step + value


@intrinsic_for(_count_lanes)
def count_lanes(typing, target, to, value, step):
    """Write ``value``, and so much more in each of `LANES` entries."""

    def code(context, builder, signature, arguments):
        there, to, value, step = arguments
        order = ir.Constant(ir.VectorType(ir.IntType(32), LANES), list(range(LANES)))
        more = builder.mul(_all_lanes(builder, step), order)
        entries = builder.add(_all_lanes(builder, value), more)
        builder.store(entries, _lanes(context, builder, target, there, to), align=4)
        return context.get_dummy_value()

    return types.none(target, to, types.uint32, types.uint32), code


def _near(position, edges, place, first, limit):
    first = int(first)
    apart = position[:, int(place), None] - position[:, first : first + LANES]
    nearer = (apart * apart).sum(axis=0) < limit
    return np.uint64(sum(1 << t for t in np.flatnonzero(nearer)))


@intrinsic_for(_near)
def near(typing, position, edges, place, first, limit):
    """Which of `LANES` places from ``first`` on lie nearer than sqrt(limit) to ``place``.

    Written out as vectors because no loop with this few turns is made into them.
    """

    def code(context, builder, signature, arguments):
        array, _, place, first, limit = arguments
        vector = ir.VectorType(context.get_data_type(position.dtype), LANES)
        square = ir.Constant(vector, [0.0] * LANES)
        ours = _column(context, builder, position, array, place, len(edges))
        theirs = _column(context, builder, position, array, first, len(edges))
        for one, other in zip(ours, theirs):
            others = builder.load(builder.bitcast(other, vector.as_pointer()), align=4)
            apart = builder.fsub(_all_lanes(builder, builder.load(one)), others)
            squared = builder.fmul(apart, apart, flags=["contract"])
            square = builder.fadd(square, squared, flags=["contract"])
        hit = builder.fcmp_ordered("<", square, _all_lanes(builder, limit))
        return builder.zext(builder.bitcast(hit, ir.IntType(LANES)), ir.IntType(64))

    return types.uint64(position, edges, place, first, position.dtype), code


def _pack(target, to, source, first, bits):
    chosen = [source[int(first) + t] for t in range(LANES) if int(bits) >> t & 1]
    target[int(to) : int(to) + len(chosen)] = chosen


@intrinsic_for(_pack)
def pack(typing, target, to, source, first, bits):
    """Copy those of `LANES` entries whose bits are set; what follows them in the target is lost."""

    def code(context, builder, signature, arguments):
        there, to, given, first, bits = arguments
        entries = _lanes(context, builder, source, given, first)
        _pack_lanes(builder, entries, _lanes(context, builder, target, there, to), bits)
        return context.get_dummy_value()

    return types.none(target, to, source, first, bits), code


def _pack_lanes(builder, source, target, bits):
    """Pack one vector into another, by pointers; what is too long for a register in parts."""
    size = 8 if source.type.pointee.element == ir.DoubleType() else 4
    entry, lanes = ir.IntType(8 * size), (HALF if PERMUTES else CACHE_LINE) // size
    kind = ir.VectorType(entry, lanes)
    source, target = (builder.bitcast(each, entry.as_pointer()) for each in (source, target))
    for begin in range(0, LANES, lanes):
        some = builder.trunc(builder.lshr(bits, ir.Constant(bits.type, begin)), ir.IntType(lanes))
        at = builder.gep(source, [cgutils.intp_t(begin)])
        entries = builder.load(builder.bitcast(at, kind.as_pointer()), align=size)
        packed = _packed(builder, entries, some)
        builder.store(packed, builder.bitcast(target, kind.as_pointer()), align=size)
        target = builder.gep(target, [builder.zext(builder.ctpop(some), ir.IntType(64))])


def _packed(builder, entries, some):
    """A vector that begins with the entries whose bit is set.

    AVX2 has no instruction for that: its words are put in an order that a table has for all bits.
    """
    kind, lanes = entries.type, some.type.width
    if not PERMUTES:
        chosen = ir.VectorType(ir.IntType(1), lanes)
        name = f"llvm.experimental.vector.compress.v{lanes}{kind.element.intrinsic_name}"
        form = ir.FunctionType(kind, [kind, chosen, kind])
        compress = cgutils.get_or_insert_function(builder.module, form, name)
        arguments = entries, builder.bitcast(some, chosen), ir.Constant(kind, None)
        return builder.call(compress, arguments)
    words, order = ir.VectorType(ir.IntType(32), 8), ir.VectorType(ir.IntType(8), 8)
    chosen = [np.repeat([b >> t & 1 for t in range(lanes)], 8 // lanes) for b in range(2**lanes)]
    table = [ir.Constant(order, np.argsort(1 - bits, kind="stable").tolist()) for bits in chosen]
    table = ir.Constant(ir.ArrayType(order, len(table)), table)
    place = [cgutils.intp_t(0), builder.zext(some, cgutils.intp_t)]
    place = builder.gep(cgutils.global_constant(builder, "orders", table), place)
    form = ir.FunctionType(words, [words, words])
    permute = cgutils.get_or_insert_function(builder.module, form, "llvm.x86.avx2.permd")
    arguments = builder.bitcast(entries, words), builder.zext(builder.load(place), words)
    return builder.bitcast(builder.call(permute, arguments), kind)


def _pack_columns(array, to, first, bits, edges):
    for k in range(len(edges)):
        _pack(array[k], to, array[k], first, bits)


@intrinsic_for(_pack_columns)
def pack_columns(typing, array, to, first, bits, edges):
    """The same of columns of an array, inside it."""

    def code(context, builder, signature, arguments):
        given, to, first, bits, _ = arguments
        vector = ir.VectorType(ir.DoubleType(), LANES).as_pointer()
        for columns in zip(
            _column(context, builder, array, given, first, len(edges)),
            _column(context, builder, array, given, to, len(edges)),
        ):
            _pack_lanes(builder, *(builder.bitcast(each, vector) for each in columns), bits)
        return context.get_dummy_value()

    return types.none(array, to, first, bits, edges), code


@inlined()
def inverse_root(x):
    """1 / sqrt(x) within 0.6 ulp: in single precision, and a step that cubes the error."""
    y = np.float64(np.float32(1.0) / np.sqrt(np.float32(x)))
    error = 1.0 - x * y * y
    return y + y * error * (0.5 + 0.375 * error)


@inlined()
def of_pair(values, species, i, j):
    """The value for the species of the beads in slots i and j; 1 without values."""
    if values is None:
        return 1.0
    if species is None:
        return values[0, 0]
    return values[species[i], species[j]]


@inlined()
def of_bead(values, species, s):
    """The value for the species of the bead in slot s; 1 without values."""
    if values is None:
        return 1.0
    if species is None:
        return values[0]
    return values[species[s]]


@inlined()
def velocity_seen(velocity, predicted):
    """What the friction sees."""
    if predicted is None:
        return velocity
    return predicted
