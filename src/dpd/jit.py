"""The one place that says how kernels are compiled.

`kernel` is for what Python calls, `inlined` for the device functions that kernels call; in Python
such a function stays a plain one. LLVM inlines them: one kept apart is optimised otherwise when it
is compiled than when Numba's disk cache has it, and a resumed run would differ in its last bits.

Numba would link, optimise and emit every function with all that it calls. Here a kernel links in
each function below it once, and is optimised and emitted as a whole. Nor do they count who holds an
array, which cost 5 % of a step: what Python passes to a kernel lives until it returns.
"""

import inspect
import os
import stat
import sys
import warnings
from collections.abc import Callable
from contextlib import suppress
from functools import cache, partial, wraps
from importlib import import_module
from pathlib import Path
from typing import Any

from dpd.digests import kernel_digest, text_digest
from dpd.folders import cache_folder

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
from numba.core import codegen, event
from numba.core.caching import NullCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_machinery import PassManager
from numba.core.dispatcher import Dispatcher
from numba.extending import intrinsic, overload

from dpd.errors import reason
from dpd.page import PARTS

# LLVM uses half the width of AVX-512 on Intel's processors, unless told. Not by the environment,
# which a job on another processor would inherit.
FEATURES: str = numba.config.CPU_FEATURES or codegen.get_host_cpu_features()  # type: ignore[attr-defined]
WIDE = "+avx512f" in FEATURES
if WIDE:
    numba.config.CPU_FEATURES = f"{FEATURES},-prefer-256-bit"  # type: ignore[attr-defined]

# Numba looks for SciPy's linear algebra when it loads the first kernel, which takes 0.2 s of the
# 0.7 to a first step, and goes without where there is none. No kernel here needs it.
BLAS = "scipy.linalg.cython_blas"
if BLAS not in sys.modules:
    sys.modules[BLAS] = None  # type: ignore[assignment]  # so that importing it fails
    try:
        import_module("numba.np.arraymath")  # where Numba looks
    finally:
        del sys.modules[BLAS]


class _Parts(JITCodeLibrary):
    """Of a device function: nothing is linked, optimised or emitted."""

    def __init__(self, codegen, name):
        super().__init__(codegen, name)
        self.environments = {}

    @property
    def codegen(self):
        """What `get_executable` tells the environment to: left for the kernel."""
        return self

    def set_env(self, name, environment):
        self.environments[name] = environment

    def finalize(self):
        """Nothing is left to do, but to let other modules hold the same functions."""
        for function in self._final_module.functions:
            if not function.is_declaration:
                function.linkage = "linkonce_odr"
        self._shared_module = self._final_module
        self._finalized = True

    def get_pointer_to_function(self, name):
        return 0  # null: there is no code of its own


class _Whole(JITCodeLibrary):
    """Of a kernel: all device functions below it are linked in, each once."""

    def finalize(self):
        below = dict.fromkeys(self._linking_libraries)
        found = list(below)
        for library in found:
            if isinstance(library, _Parts):
                found += [inner for inner in library._linking_libraries if inner not in below]
                below.update(dict.fromkeys(library._linking_libraries))
        self._linking_libraries = list(below)
        super().finalize()
        there = {variable.name for variable in self._final_module.global_variables}
        for library in below:
            if isinstance(library, _Parts):
                for name in there & set(library.environments):
                    self._codegen.set_env(name, library.environments[name])


UNNEEDED = (
    "WithLifting", "InlineClosureLikes", "RewriteDynamicRaises", "MakeFunctionToJitFunction",
    "InlineInlinables", "FindLiterallyCalls", "LiteralUnroll", "LiteralPropagationSubPipelinePass",
    "InlineOverloads", "NopythonRewrites", "DumpParforDiagnostics",
)  # fmt: skip


class PartCompiler(Compiler):
    """Numba's own compiler, with a library of ours to fill."""

    library: type[JITCodeLibrary] = _Parts

    def define_pipelines(self) -> list[Any]:
        """Numba's passes without the `UNNEEDED`."""
        state = self.state
        state.library = self.library(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        (numbas,) = super().define_pipelines()
        ours = PassManager(numbas.pipeline_name)
        for each, description in numbas.passes:
            if each.__name__ not in UNNEEDED:
                ours.add_pass(each, description)
        ours.finalize()
        return [ours]


class KernelCompiler(PartCompiler):
    library = _Whole


COMPILES = not numba.config.DISABLE_JIT  # type: ignore[attr-defined]  # Numba sets it at run time
# NumPy's rules for division (no exceptions) and freedom to reorder sums let LLVM
# vectorise; NaN and infinity keep their meaning, the blow-up check needs them.
OPTIONS = {"error_model": "numpy", "fastmath": {"contract", "reassoc", "nsz", "arcp"}}
# The compilers above need what is private in Numba. Another version compiles all as it does by
# itself, to other last bits, in twice the time.
OURS = numba.__version__.startswith("0.68.")
OF_KERNELS: dict[str, Any] = {"pipeline_class": KernelCompiler, "_nrt": False} if OURS else {}
OF_PARTS: dict[str, Any] = {"pipeline_class": PartCompiler, "_nrt": False} if OURS else {}
KERNEL = {"nogil": True, "no_cfunc_wrapper": True} | OF_KERNELS | OPTIONS
INLINED = {"forceinline": True, "no_cfunc_wrapper": True} | OF_PARTS | OPTIONS
ALLOCATES = {"_nrt": True} if OURS else {}
CACHE = os.environ["NUMBA_CACHE_DIR"]


def kernel(allocates: bool = False) -> Callable[[Callable[..., Any]], Dispatcher]:
    """Decorator of what Python calls: compiled at its first call, cached on a disk that lets it.

    It says if it ``allocates`` arrays itself, or takes a random generator.
    """

    def decorate(function):
        if not COMPILES:
            return function
        compiled = njit(**KERNEL | (ALLOCATES if allocates else {}))(function)
        with suppress(RuntimeError):  # nowhere to write
            compiled.enable_caching()
        files, compiled._cache = compiled._cache, NullCache()
        if not str(files.cache_path).startswith(CACHE):
            # Numba would write beside the source, where it does not notice that a function which
            # the kernel calls was changed.
            _warn("it cannot be written")
        elif _is_trusted(Path(CACHE)):
            files._cache_file = _FileOfEach(files._cache_file)
            files.save_overload = _or_without(files.save_overload)
            files.load_overload = _or_without(files.load_overload)
            compiled._cache = files
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

    Numba numbers them, and two processes may give two variants one number: a later one crashes.
    """

    def __init__(self, files):
        self._files = files  # a numba.core.caching.IndexDataCacheFile

    def save(self, key, data):
        self._files._save_data(self._name(key), (key, data))

    def load(self, key):
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


def inlined(given: str = "", **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Decorator of device functions; ``options`` are Numba's, in the place of ours.

    Where the argument named by ``given`` is None nothing is done, and nothing compiled.
    """

    def decorate(function):
        place = list(inspect.signature(function).parameters).index(given) if given else -1

        def in_python(*arguments):
            return None if arguments[place] is None else function(*arguments)

        called = wraps(function)(in_python) if given else function

        @overload(called, jit_options=INLINED | options, strict=False)
        def of_types(*arguments):
            absent = given and isinstance(arguments[place], types.NoneType)
            return (lambda *arguments: None) if absent else function

        return called

    return decorate


# For what two places must agree on to the last bit: rounded as written.
inlined_exactly = partial(inlined, fastmath=False)


def intrinsic_for(in_python: Callable[..., Any]) -> Callable[[Callable[..., Any]], Any]:
    """Decorator of LLVM instructions; the function does the same where nothing is compiled."""
    return lambda code: intrinsic(code) if COMPILES else in_python


def method(name: str) -> Callable[..., Any]:
    """A function that calls the method of that name of a NamedTuple, or gives 0 for None."""

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


class _Compiling(event.TimingListener):
    """How long kernels took to compile in this process, and who is told that one begins to."""

    _duration = 0.0
    tell: Callable[[str], None] | None = None

    def on_start(self, event: Any) -> None:
        super().on_start(event)
        if tell := self.tell:
            self.tell = None
            tell("compiling, once for this kind of scene")


COMPILING = _Compiling()
event.register("numba:compile", COMPILING)
