"""Arrays with a row for each bead, and what kernels do with rows: one, or four of pairs.

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

from dpd.jit import inlined, intrinsic_for

CACHE_LINE = 64  # bytes
FOUR = 4  # pairs that are worked on together


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


def column_at(
    context: Any, builder: Any, array_type: Any, array: Any, p: Any, dimension: int
) -> list[Any]:
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


NUMBERS = ir.VectorType(ir.DoubleType(), FOUR)
ZEROS = ir.Constant(NUMBERS, [0.0] * FOUR)
EVEN, ODD, BEGINS, ENDS = (0, 4, 2, 6), (1, 5, 3, 7), (0, 1, 4, 5), (2, 3, 6, 7)
BOTH = 0, 1, 2, 3  # of two rows of two dimensions


def _shuffled(builder, one, other, order):
    chosen = ir.Constant(ir.VectorType(ir.IntType(32), len(order)), order)
    return builder.shuffle_vector(one, other, chosen)


def _columns(builder, first, second, third, fourth):
    """The columns of four rows, padding with them.

    In seven shuffles that matter; the compiler alone takes ten, and slower ones.
    """
    pairs = (first, second), (third, fourth)
    if first.type.count < FOUR:
        joined = [_shuffled(builder, *pair, BOTH) for pair in zip(*pairs)]
        return [_shuffled(builder, *joined, order) for order in (EVEN, ODD)]
    halves = [[_shuffled(builder, *pair, order) for pair in pairs] for order in (EVEN, ODD)]
    return [_shuffled(builder, *half, order) for order in (BEGINS, ENDS) for half in halves]


def _rows_of(builder, columns):
    """The same back, with zeros for padding."""
    if len(columns) > 2:
        return _columns(builder, *columns, ZEROS)
    turned = [_shuffled(builder, *columns, order) for order in (EVEN, ODD)]
    halves = (0, 1), (2, 3)
    return [_shuffled(builder, each, each, half) for half in halves for each in turned]


def _four(builder, entry):
    """Pointer to four numbers from a pointer to the first."""
    return builder.bitcast(entry, NUMBERS.as_pointer())


def _rows(context, builder, edges, kind, array, places, places_array, p):
    """Of an array, the rows that four entries of ``places`` tell, from p on."""
    made = context.make_array(places)(context, builder, places_array)
    for q in range(FOUR):
        at = builder.gep(made.data, [builder.add(p, ir.Constant(p.type, q))])
        row = _row(context, builder, kind, array, builder.load(at), _row_vector(edges))
        yield builder.load(row, align=8)


def _columns_apart(builder, edges, ours, theirs):
    """The columns of four rows minus four others."""
    return _columns(builder, *map(builder.fsub, ours, theirs))[: len(edges)]


def in_all(builder: Any, value: Any, lanes: int) -> Any:
    free = ir.Constant(ir.VectorType(value.type, lanes), ir.Undefined)
    one = builder.insert_element(free, value, cgutils.int32_t(0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), lanes), [0] * lanes)
    return builder.shuffle_vector(one, free, zeros)


def _nearest(builder, apart, edges):
    """Columns at their nearest image."""
    form = ir.FunctionType(NUMBERS, [NUMBERS])
    rint = cgutils.get_or_insert_function(builder.module, form, "llvm.rint.v4f64")
    for column, edge in zip(apart, edges):
        inverse = in_all(builder, builder.fdiv(ir.Constant(edge.type, 1.0), edge), FOUR)
        boxes = builder.call(rint, [builder.fmul(column, inverse)])
        back = builder.fmul(boxes, in_all(builder, edge, FOUR), flags=["contract"])
        yield builder.fsub(column, back, flags=["contract"])


def _apart_to_columns(target, p, x, i, j, edges, slide, move, m):
    for q in range(int(p), int(p) + FOUR):
        for k in range(len(edges)):
            target[k, q] = x[i[q], k] - (x[j[q], k] + (0.0 if move is None else move[m[q], k]))
            if move is None and slide is None:
                target[k, q] -= edges[k] * np.rint(target[k, q] / edges[k])


@intrinsic_for(_apart_to_columns)
def apart_to_columns(typing, target, p, x, i, j, edges, slide, move, m):
    """Make rows i minus rows j, these moved by rows m, columns p to p + 3 of ``target``.

    i, j and m are arrays, read from p on. Without ``move`` separations are put at their nearest
    image, but where images slide.
    """

    def code(context, builder, signature, arguments):
        to, p, rows, i_array, j_array, lengths, _, move_array, m_array = arguments
        chosen = partial(_rows, context, builder, edges, p=p)
        theirs = chosen(x, rows, j, j_array)
        if move is not types.none:
            theirs = map(builder.fadd, theirs, chosen(move, move_array, m, m_array))
        apart = _columns_apart(builder, edges, chosen(x, rows, i, i_array), theirs)
        if move is types.none and slide is types.none:
            apart = _nearest(builder, apart, cgutils.unpack_tuple(builder, lengths))
        for column, entry in zip(apart, column_at(context, builder, target, to, p, len(edges))):
            builder.store(column, _four(builder, entry), align=8)
        return context.get_dummy_value()

    return types.none(target, p, x, i, j, edges, slide, move, m), code


def _differences_along(target, p, rows, i, j, along, edges):
    for q in range(int(p), int(p) + FOUR):
        target[q] = difference_along(rows, i[q], j[q], along, q, edges)


@intrinsic_for(_differences_along)
def differences_along(typing, target, p, rows, i, j, along, edges):
    """Make `difference_along` of four pairs entries p to p + 3 of ``target``."""

    def code(context, builder, signature, arguments):
        to, p, array, i_array, j_array, along_array, _ = arguments
        chosen = partial(_rows, context, builder, edges, rows, array, p=p)
        apart = _columns_apart(builder, edges, chosen(i, i_array), chosen(j, j_array))
        total = ZEROS
        for column, entry in zip(
            apart, column_at(context, builder, along, along_array, p, len(edges))
        ):
            other = builder.load(_four(builder, entry), align=8)
            product = builder.fmul(column, other, flags=["contract"])
            total = builder.fadd(total, product, flags=["contract", "nsz"])
        made = context.make_array(target)(context, builder, to)
        builder.store(total, _four(builder, builder.gep(made.data, [p])), align=8)
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
        column = column_at(context, builder, along, along_array, p, len(edges))
        for k, entry in enumerate(column):
            component = builder.fmul(scale, builder.load(entry))
            push = builder.insert_element(push, component, cgutils.int32_t(k))
        for place, change in ((i, builder.fadd), (j, builder.fsub)):
            row = _row(context, builder, force, array, place, vector)
            builder.store(change(builder.load(row, align=8), push), row, align=8)
        return context.get_dummy_value()

    return types.none(force, i, j, scale, along, p, edges), code


def _push_sixteen(force, i, j, scale, along, first, stride, edges):
    for t in range(FOUR):
        for p in range(int(first) + t, int(first) + t + FOUR * int(stride), int(stride)):
            push_apart(force, i[p], j[p], scale[p], along, p, edges)


@intrinsic_for(_push_sixteen)
def push_sixteen(typing, force, i, j, scale, along, first, stride, edges):
    """Do `push_apart` for four pairs from ``first`` on, and those 1, 2 and 3 strides further.

    i, j and scale are arrays. The first of each four are pushed first, then the second.
    """

    def code(context, builder, signature, arguments):
        array, *given, along_array, place, stride, _ = arguments
        ends_i, ends_j, scales = (
            context.make_array(kind)(context, builder, value).data
            for kind, value in zip((i, j, scale), given)
        )
        vector, places = _row_vector(edges), []
        for _ in range(FOUR):
            entries = column_at(context, builder, along, along_array, place, len(edges))
            entries = [builder.gep(scales, [place]), *entries]
            many, *columns = (builder.load(_four(builder, each), align=8) for each in entries)
            rows = _rows_of(builder, [builder.fmul(many, column) for column in columns])
            places.append((place, rows))
            place = builder.add(place, stride)
        for t in range(FOUR):
            for place, rows in places:
                at = builder.add(place, ir.Constant(place.type, t))
                for ends, change in ((ends_i, builder.fadd), (ends_j, builder.fsub)):
                    slot = builder.load(builder.gep(ends, [at]))
                    row = _row(context, builder, force, array, slot, vector)
                    builder.store(change(builder.load(row, align=8), rows[t]), row, align=8)
        return context.get_dummy_value()

    return types.none(force, i, j, scale, along, first, stride, edges), code


@inlined()
def first_given(array, other):
    """An array, or the other where it is None."""
    if array is None:
        return other
    return array
