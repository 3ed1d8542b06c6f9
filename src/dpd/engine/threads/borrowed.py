"""Arrays that a kernel uses but does not own.

Wherever compiled code passes on a record with arrays, or takes a field out of it, it counts the
new holder of each array with an atomic operation. In the forces of one batch of pairs that
happens dozens of times, and took 5 % of the time of a step. What Python passes to a kernel lives
until the kernel returns, so inside the kernel nothing needs to be counted.
"""

from numba import types
from numba.core import cgutils
from numba.core.imputils import impl_ret_new_ref
from numba.extending import intrinsic


@intrinsic
def borrowed(typing, record):
    """The same record or array without an owner. Never to be returned to Python."""

    def code(context, builder, signature, arguments):
        value = _without_owner(context, builder, signature.args[0], arguments[0])
        return impl_ret_new_ref(context, builder, signature.return_type, value)

    return record(record), code


def _without_owner(context, builder, kind, value):
    """A record or an array as above; anything else as it is."""
    if isinstance(kind, types.Array):
        array = context.make_array(kind)(context, builder, value)
        array.meminfo = cgutils.get_null_value(array.meminfo.type)
        array.parent = cgutils.get_null_value(array.parent.type)
        return array._getvalue()
    if isinstance(kind, types.BaseTuple):
        for place, of_place in enumerate(kind.types):
            item = builder.extract_value(value, place)
            item = _without_owner(context, builder, of_place, item)
            value = builder.insert_value(value, item, place)
    return value
