"""The one place that says how kernels are compiled.

`kernel` is for what Python calls, `inlined` for the device functions that kernels call; in Python
such a function stays a plain one. LLVM inlines them: a function kept apart is optimised differently
when it is compiled afresh and when it is read from Numba's disk cache, and a resumed run would
differ in its last bits. With NUMBA_DISABLE_JIT=1 all of it runs as Python.
"""

from __future__ import annotations

import os
import stat
import sys
import time
import warnings
from functools import cache, partial, wraps
from importlib import import_module
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dpd.digest import cache_folder, text_digest
from dpd.sources import kernel_digest

# What Numba reads when it is imported, or again if a program has imported it before. Its disk cache
# does not notice that a called function changed in another file, so its folder is named after the
# digest of the kernels' sources. LLVM's higher levels of optimisation make compilation a fifth
# longer and no kernel faster: loops vectorise at level 1, which decides the last bits of results.
os.environ.setdefault("NUMBA_CACHE_DIR", str(cache_folder(kernel_digest())))
os.environ["NUMBA_OPT"] = "1"
if "numba" in sys.modules:
    sys.modules["numba"].core.config.reload_config()

# isort: split
import numba
from numba import njit, types
from numba.core import event
from numba.core.caching import NullCache
from numba.extending import intrinsic, overload

from dpd.errors import reason
from dpd.lazy_parts import compilers
from dpd.page import PARTS

if TYPE_CHECKING:
    from collections.abc import Callable

    from numba.core.caching import IndexDataCacheFile
    from numba.core.dispatcher import Dispatcher


def _without_blas():
    """Spare every process SciPy's linear algebra, which takes 0.2 s of the 0.7 to a first step.

    Numba looks for it once, when it loads the first kernel, and goes without where there is none.
    No kernel here needs it.
    """
    blas = "scipy.linalg.cython_blas"
    if blas not in sys.modules:
        sys.modules[blas] = None  # so that importing it fails
        try:
            import_module("numba.np.arraymath")  # where Numba looks
        finally:
            del sys.modules[blas]


_without_blas()

COMPILES = not numba.config.DISABLE_JIT  # type: ignore[attr-defined]  # Numba sets it at run time
# NumPy's rules for division (no exceptions) and freedom to reorder sums let LLVM
# vectorise; NaN and infinity keep their meaning, the blow-up check needs them.
OPTIONS = {"error_model": "numpy", "fastmath": {"contract", "reassoc", "nsz", "arcp"}}
OF_KERNELS, OF_PARTS = compilers()
KERNEL = {"nogil": True, "no_cfunc_wrapper": True} | OF_KERNELS | OPTIONS
ALLOCATES = {"_nrt": True} if "_nrt" in OF_KERNELS else {}
CACHE = os.environ["NUMBA_CACHE_DIR"]


def kernel(allocates: bool = False) -> Callable[[Callable[..., Any]], Dispatcher]:
    """Decorator of what Python calls: compiled at its first call, and kept on the disk.

    A disk that is full or may not be written is no reason not to run.

    Parameters
    ----------
    allocates : bool
        Whether it makes arrays itself, or takes a random generator.
    """

    def decorate(function):
        if not COMPILES:
            return function
        compiled = njit(**KERNEL | (ALLOCATES if allocates else {}))(function)
        try:
            compiled.enable_caching()
            kept = compiled._cache
        except RuntimeError:  # nowhere to write
            kept = NullCache()
        if not _is_trusted(Path(CACHE)):
            compiled._cache = kept = NullCache()
        elif not str(kept.cache_path).startswith(CACHE):
            # Numba would keep it beside its source, where it does not notice that a function
            # which the kernel calls was changed.
            _warn("it cannot be written")
            compiled._cache = kept = NullCache()
        else:
            kept._cache_file = _FileOfEach(kept._cache_file)
        kept.save_overload = _or_without(kept.save_overload)
        kept.load_overload = _or_without(kept.load_overload)
        return compiled

    return decorate


@cache
def _is_trusted(folder):
    """Whether nobody else can have put code into a folder, which would be run."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        there = folder.stat()
    except OSError:  # nothing is read there
        return True
    if there.st_uid in (0, os.getuid()) and not there.st_mode & stat.S_IWOTH:
        return True
    _warn("another user can write there; NUMBA_CACHE_DIR names another folder")
    return False


class _FileOfEach:
    """Files of a kernel's variants, each named after the arguments that it is compiled for.

    Numba numbers them, and an index says which is which. Two processes that compile at the same
    time may take the same number for two variants, and a later one then runs code that was made
    for other arguments, and crashes.

    Parameters
    ----------
    files : numba.core.caching.IndexDataCacheFile
        That writes and reads them.
    """

    def __init__(self, files: IndexDataCacheFile) -> None:
        self._files = files

    def save(self, key: tuple[Any, ...], data: tuple[Any, ...]) -> None:
        """Write a variant, as Numba reduces it, in the place of what was there."""
        self._files._save_data(self._name(key), (key, data))

    def load(self, key: tuple[Any, ...]) -> tuple[Any, ...] | None:
        """A variant; None if it was not written yet."""
        try:
            found, data = self._files._load_data(self._name(key))
        except FileNotFoundError:
            return None
        return data if found == key else None

    def _name(self, key):
        made_with = numba.__version__, self._files._source_stamp, key
        return f"{Path(self._files._index_name).stem}.{text_digest(repr(made_with))}.nbc"


def _or_without(call):
    """A call to Numba's cache; nothing where it fails."""

    def attempt(*arguments):
        try:
            return call(*arguments)
        except Exception as problem:  # pickle has a dozen for files that are damaged
            _warn(reason(problem))
            return None

    return attempt


@cache  # one sentence for all kernels
def _warn(why):
    warnings.warn(
        f"{CACHE}: compiled kernels cannot be kept ({why}); this process compiles its own, which "
        "takes a minute", stacklevel=2,
    )  # fmt: skip


INLINED = {"forceinline": True, "no_cfunc_wrapper": True} | OF_PARTS | OPTIONS


def inlined(given: str = "", **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Decorator of device functions.

    Parameters
    ----------
    given : str
        Name of an argument. Where that is None the function does nothing, and nothing is compiled
        for it.
    **options
        Of Numba, in the place of ours.
    """

    def decorate(function):
        place = list(signature(function).parameters).index(given) if given else -1

        def in_python(*arguments):
            return None if arguments[place] is None else function(*arguments)

        called = wraps(function)(in_python) if given else function

        @overload(called, jit_options=INLINED | options, strict=False)
        def of_types(*arguments):
            absent = given and isinstance(arguments[place], types.NoneType)
            return _nothing if absent else function

        return called

    return decorate


def _nothing(*arguments):
    """What takes the place of a function that is not needed."""


# For what two places must agree on to the last bit: rounded as written.
inlined_exactly = partial(inlined, fastmath=False)


def intrinsic_for(in_python: Callable[..., Any]) -> Callable[[Callable[..., Any]], Any]:
    """Decorator of LLVM instructions, with the function that does the same in Python.

    The latter takes its place where nothing is compiled.
    """
    return lambda code: intrinsic(code) if COMPILES else in_python


def method(name: str) -> Callable[..., Any]:
    """A function that calls the method of that name of its first argument, a NamedTuple.

    In a kernel the class is known when it is compiled, and the method is inlined. What is absent,
    None, gives 0.
    """

    def call(record, *arguments):
        return 0.0 if record is None else getattr(record, name)(*arguments)

    # Numba's hints do not know all options of INLINED.
    @overload(call, strict=False, jit_options=INLINED)  # type: ignore[arg-type]
    def of_class(record, *arguments):
        while PARTS:  # of the page, which does not import Numba
            inlined()(PARTS.pop())
        if isinstance(record, types.NoneType):
            return lambda record, *arguments: 0.0
        return getattr(record.instance_class, name)

    return call


class _Compiling(event.Listener):
    """How long kernels took to compile in this process, and who is told that one begins to."""

    def __init__(self) -> None:
        self.seconds = 0.0
        self.tell: Callable[[str], None] | None = None
        self._depth = self._since = 0.0  # a kernel's parts compile while it does

    def on_start(self, event: Any) -> None:
        """A function begins to compile."""
        if not self._depth:
            self._since = time.perf_counter()
            if self.tell:
                self.tell("compiling, once for this kind of scene")
            self.tell = None
        self._depth += 1

    def on_end(self, event: Any) -> None:
        """It is compiled."""
        self._depth -= 1
        if not self._depth:
            self.seconds += time.perf_counter() - self._since


COMPILING = _Compiling()
event.register("numba:compile", COMPILING)
