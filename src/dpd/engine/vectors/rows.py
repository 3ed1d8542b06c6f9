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


def _axes(space):
    """Axes of the type of a `dpd.engine.space.Space`."""
    return len(space.types[0])


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
def copy_row(typing, target, s, source, i, space):
    """Copy row i to row s."""
    vector = ir.VectorType(ir.DoubleType(), row_width(_axes(space)))

    def code(context, builder, signature, arguments):
        target_array, s, source_array, i, _ = arguments
        to = _row(context, builder, target, target_array, s, vector)
        at = _row(context, builder, source, source_array, i, vector)
        builder.store(builder.load(at, align=8), to, align=8)
        return context.get_dummy_value()

    return types.none(target, s, source, i, space), code


@intrinsic
def sum_to_column(typing, target, p, source, i, shift, m, space):
    """Make row i of one array plus row m of another column p of a (dimension, n) array."""
    vector = ir.VectorType(ir.DoubleType(), row_width(_axes(space)))

    def code(context, builder, signature, arguments):
        target_array, p, source_array, i, shift_array, m, _ = arguments
        row = builder.load(_row(context, builder, source, source_array, i, vector), align=8)
        by = builder.load(_row(context, builder, shift, shift_array, m, vector), align=8)
        total = builder.fadd(row, by)
        column = _column(context, builder, target, target_array, p, _axes(space))
        for k, entry in enumerate(column):
            builder.store(builder.extract_element(total, _lane(k)), entry)
        return context.get_dummy_value()

    return types.none(target, p, source, i, shift, m, space), code


@intrinsic
def difference_along(typing, rows, i, j, along, p, space):
    """Scalar product of row i minus row j and column p of ``along``."""
    vector = ir.VectorType(ir.DoubleType(), row_width(_axes(space)))

    def code(context, builder, signature, arguments):
        array, i, j, along_array, p, _ = arguments
        ours = builder.load(_row(context, builder, rows, array, i, vector), align=8)
        theirs = builder.load(_row(context, builder, rows, array, j, vector), align=8)
        apart = builder.fsub(ours, theirs)
        total = ir.Constant(ir.DoubleType(), 0.0)
        column = _column(context, builder, along, along_array, p, _axes(space))
        for k, entry in enumerate(column):
            component = builder.extract_element(apart, _lane(k))
            product = builder.fmul(component, builder.load(entry), flags=["contract"])
            total = builder.fadd(total, product, flags=["contract", "nsz"])
        return total

    return types.float64(rows, i, j, along, p, space), code


@intrinsic
def push_apart(typing, force, i, j, scale, along, p, space):
    """Add scale times column p of ``along`` to row i, and take the same off row j."""
    width = row_width(_axes(space))
    vector = ir.VectorType(ir.DoubleType(), width)

    def code(context, builder, signature, arguments):
        array, i, j, scale, along_array, p, _ = arguments
        push = ir.Constant(vector, [0.0] * width)
        column = _column(context, builder, along, along_array, p, _axes(space))
        for k, entry in enumerate(column):
            component = builder.fmul(scale, builder.load(entry))
            push = builder.insert_element(push, component, _lane(k))
        for place, change in ((i, builder.fadd), (j, builder.fsub)):
            row = _row(context, builder, force, array, place, vector)
            builder.store(change(builder.load(row, align=8), push), row, align=8)
        return context.get_dummy_value()

    return types.none(force, i, j, scale, along, p, space), code


@part()
def entries(mine, rows):
    """First and end of the entries of rows mine.first to mine.end."""
    width = np.uint64(rows.shape[1])
    return np.uint64(mine.first * width), np.uint64(mine.end * width)


@part()
def add_rows(target, source, share, mine):
    """Add that share of one array's rows to those of another."""
    to, more = target.ravel(), source.ravel()
    begin, end = entries(mine, target)
    for q in range(begin, end):
        to[q] += share * more[q]
