"""What searches do with sixteen numbers at a time, written out as in `dpd.engine.rows`."""

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils

from dpd.engine.rows import column_at, in_all
from dpd.jit import FEATURES, WIDE, intrinsic_for

LANES = 16
WHOLE, HALF = 64, 32  # bytes: the registers of AVX-512, and of AVX2
PERMUTES = "+avx2" in FEATURES and not WIDE


def _lanes(context, builder, array_type, array, first):
    """Pointer to `LANES` entries of an array with one axis as a vector."""
    made = context.make_array(array_type)(context, builder, array)
    vector = ir.VectorType(context.get_data_type(array_type.dtype), LANES)
    return builder.bitcast(builder.gep(made.data, [first]), vector.as_pointer())


def _copy_lanes(target, to, source, first, by):
    to, first = int(to), int(first)
    target[to : to + LANES] = source[first : first + LANES] + by


@intrinsic_for(_copy_lanes)
def copy_lanes(typing, target, to, source, first, by):
    """Copy `LANES` numbers, and add ``by`` to each."""

    def code(context, builder, signature, arguments):
        there, to, given, first, by = arguments
        entries = builder.load(_lanes(context, builder, source, given, first), align=4)
        moved = builder.fadd(entries, in_all(builder, by, LANES))
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
        more = builder.mul(in_all(builder, step, LANES), order)
        entries = builder.add(in_all(builder, value, LANES), more)
        builder.store(entries, _lanes(context, builder, target, there, to), align=4)
        return context.get_dummy_value()

    return types.none(target, to, types.uint32, types.uint32), code


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
        ours = column_at(context, builder, position, array, place, len(edges))
        theirs = column_at(context, builder, position, array, first, len(edges))
        for one, other in zip(ours, theirs):
            others = builder.load(builder.bitcast(other, vector.as_pointer()), align=4)
            apart = builder.fsub(in_all(builder, builder.load(one), LANES), others)
            squared = builder.fmul(apart, apart, flags=["contract"])
            square = builder.fadd(square, squared, flags=["contract"])
        hit = builder.fcmp_ordered("<", square, in_all(builder, limit, LANES))
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
    entry, lanes = ir.IntType(8 * size), (HALF if PERMUTES else WHOLE) // size
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
            column_at(context, builder, array, given, first, len(edges)),
            column_at(context, builder, array, given, to, len(edges)),
        ):
            _pack_lanes(builder, *(builder.bitcast(each, vector) for each in columns), bits)
        return context.get_dummy_value()

    return types.none(array, to, first, bits, edges), code
