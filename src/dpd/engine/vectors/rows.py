"""Rows of beads: one or two at once as vectors, or all their entries one after the other.

What loads and stores a row at once is written out, because the compiler does not join its
entries into a vector by itself: Numba leaves that pass of LLVM out.
"""

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from dpd.engine.vectors.arrays import row_width
from dpd.jit import part

STRETCH = 256  # entries whose edges are written out, for a loop without a look at the axis


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


def _lane(k):
    return ir.Constant(ir.IntType(32), k)


@intrinsic
def copy_row(typing, target, s, source, i, box):
    """Copy row i to row s."""
    vector = ir.VectorType(ir.DoubleType(), row_width(len(box)))

    def code(context, builder, signature, arguments):
        to = _row(context, builder, target, arguments[0], arguments[1], vector)
        at = _row(context, builder, source, arguments[2], arguments[3], vector)
        builder.store(builder.load(at, align=8), to, align=8)
        return context.get_dummy_value()

    return types.none(target, s, source, i, box), code


@intrinsic
def sum_to_column(typing, target, p, source, i, shift, m, box):
    """Make row i of one array plus row m of another column p of a (dimension, n) array."""
    vector = ir.VectorType(ir.DoubleType(), row_width(len(box)))

    def code(context, builder, signature, arguments):
        target_array, p, source_array, i, shift_array, m, _ = arguments
        row = builder.load(_row(context, builder, source, source_array, i, vector), align=8)
        by = builder.load(_row(context, builder, shift, shift_array, m, vector), align=8)
        total = builder.fadd(row, by)
        column = _column(context, builder, target, target_array, p, len(box))
        for k, entry in enumerate(column):
            builder.store(builder.extract_element(total, _lane(k)), entry)
        return context.get_dummy_value()

    return types.none(target, p, source, i, shift, m, box), code


@intrinsic
def difference_along(typing, rows, i, j, along, p, box):
    """Scalar product of row i minus row j and column p of ``along``."""
    vector = ir.VectorType(ir.DoubleType(), row_width(len(box)))

    def code(context, builder, signature, arguments):
        array, i, j, along_array, p, _ = arguments
        ours = builder.load(_row(context, builder, rows, array, i, vector), align=8)
        theirs = builder.load(_row(context, builder, rows, array, j, vector), align=8)
        apart = builder.fsub(ours, theirs)
        total = ir.Constant(ir.DoubleType(), 0.0)
        column = _column(context, builder, along, along_array, p, len(box))
        for k, entry in enumerate(column):
            component = builder.extract_element(apart, _lane(k))
            product = builder.fmul(component, builder.load(entry), flags=["contract"])
            total = builder.fadd(total, product, flags=["contract", "nsz"])
        return total

    return types.float64(rows, i, j, along, p, box), code


@intrinsic
def push_apart(typing, force, i, j, scale, along, p, box):
    """Add scale times column p of ``along`` to row i, and take the same off row j."""
    width = row_width(len(box))
    vector = ir.VectorType(ir.DoubleType(), width)

    def code(context, builder, signature, arguments):
        array, i, j, scale, along_array, p, _ = arguments
        push = ir.Constant(vector, [0.0] * width)
        column = _column(context, builder, along, along_array, p, len(box))
        for k, entry in enumerate(column):
            component = builder.fmul(scale, builder.load(entry))
            push = builder.insert_element(push, component, _lane(k))
        for place, change in ((i, builder.fadd), (j, builder.fsub)):
            row = _row(context, builder, force, array, place, vector)
            builder.store(change(builder.load(row, align=8), push), row, align=8)
        return context.get_dummy_value()

    return types.none(force, i, j, scale, along, p, box), code


@part()
def entries(own, rows):
    """First and end of the entries of rows own[0] to own[1]."""
    width = np.uint64(rows.shape[1])
    return np.uint64(own[0] * width), np.uint64(own[1] * width)


@part()
def add_rows(target, source, share, own):
    """Add that share of one array's rows to those of another."""
    to, more = target.ravel(), source.ravel()
    begin, end = entries(own, target)
    for q in range(begin, end):
        to[q] += share * more[q]


@part()
def row_edges(box):
    """Edges of the box and their inverses as rows have them, over and over; 1 for padding."""
    width = row_width(len(box))
    edges = np.ones((2, STRETCH))
    for first in range(0, STRETCH, width):
        for k in range(len(box)):
            edges[0, first + k] = box[k]
            edges[1, first + k] = 1.0 / box[k]
    return edges


@part()
def put_inside(position, own, edges):
    """Move beads to their image in the box."""
    x = position.ravel()
    begin, end = entries(own, position)
    for first in range(begin, end, np.uint64(STRETCH)):
        for t in range(min(np.uint64(STRETCH), np.uint64(end - first))):
            edge = edges[0, t]
            inside = x[first + t] - edge * np.floor(x[first + t] * edges[1, t])
            x[first + t] = inside if inside < edge else 0.0
