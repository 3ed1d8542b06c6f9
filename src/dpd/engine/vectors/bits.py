"""Sets of up to 64 things as the bits of a word, for what a branch for each would slow."""

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

LANES = 8  # distances that `near` compares at a time


@intrinsic
def popcount(typing, word):
    """Number of bits that are set."""

    def code(context, builder, signature, arguments):
        return builder.ctpop(arguments[0])

    return word(word), code


@intrinsic
def lowest(typing, word):
    """Place of the lowest bit that is set; 64 if none is."""

    def code(context, builder, signature, arguments):
        return builder.cttz(arguments[0], ir.Constant(ir.IntType(1), 0))

    return word(word), code


@intrinsic
def near(typing, position, space, place, first, limit):
    """Which of `LANES` places from ``first`` on lie nearer than sqrt(limit) to ``place``.

    Written out as vectors because no loop with this few turns is made into them.
    """
    dimension = len(space.types[0])

    def code(context, builder, signature, arguments):
        array, _, place, first, limit = arguments
        array = context.make_array(position)(context, builder, array)
        vector = ir.VectorType(ir.DoubleType(), LANES)
        zero = ir.Constant(ir.IntType(32), 0)
        lanes = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)

        def all_lanes(value):
            one = builder.insert_element(ir.Constant(vector, ir.Undefined), value, zero)
            return builder.shuffle_vector(one, ir.Constant(vector, ir.Undefined), lanes)

        def pointer(k, at):
            index = [ir.Constant(at.type, k), at]
            return cgutils.get_item_pointer(context, builder, position, array, index)

        square = ir.Constant(vector, [0.0] * LANES)
        for k in range(dimension):
            ours = all_lanes(builder.load(pointer(k, place)))
            theirs = builder.bitcast(pointer(k, first), vector.as_pointer())
            apart = builder.fsub(ours, builder.load(theirs, align=8))
            squared = builder.fmul(apart, apart, flags=["contract"])
            square = builder.fadd(square, squared, flags=["contract"])
        hit = builder.fcmp_ordered("<", square, all_lanes(limit))
        return builder.zext(builder.bitcast(hit, ir.IntType(LANES)), ir.IntType(64))

    return types.uint64(position, space, place, first, limit), code
