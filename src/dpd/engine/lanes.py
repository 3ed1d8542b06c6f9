"""Instructions that take many entries of an array at once, for searches; see `dpd.engine.rows`."""

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils

from dpd.engine.rows import CACHE_LINE, column_of
from dpd.jit import intrinsic_for

LANES = 16


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


def _lanes(context, builder, array_type, array, first, lanes=LANES):
    """Pointer to some entries of an array with one axis as a vector."""
    made = context.make_array(array_type)(context, builder, array)
    vector = ir.VectorType(context.get_data_type(array_type.dtype), lanes)
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
        ours = column_of(context, builder, position, array, place, len(edges))
        theirs = column_of(context, builder, position, array, first, len(edges))
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
    size = source.dtype.bitwidth // 8
    lanes = CACHE_LINE // size  # of a vector: all, or half of them

    def code(context, builder, signature, arguments):
        there, to, given, first, bits = arguments
        kind = ir.VectorType(context.get_data_type(source.dtype), lanes)
        chosen = ir.VectorType(ir.IntType(1), lanes)
        compress = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(kind, [kind, chosen, kind]),
            f"llvm.experimental.vector.compress.v{lanes}{'i32' if size == 4 else 'f64'}",
        )  # fmt: skip
        for _ in range(LANES // lanes):
            some = builder.trunc(bits, ir.IntType(lanes))
            entries = builder.load(_lanes(context, builder, source, given, first, lanes), align=4)
            mask = builder.bitcast(some, chosen)
            packed = builder.call(compress, [entries, mask, ir.Constant(kind, None)])
            builder.store(packed, _lanes(context, builder, target, there, to, lanes), align=4)
            to = builder.add(to, builder.zext(builder.ctpop(some), to.type))
            first = builder.add(first, ir.Constant(first.type, lanes))
            bits = builder.lshr(bits, ir.Constant(bits.type, lanes))
        return context.get_dummy_value()

    return types.none(target, to, source, first, bits), code
