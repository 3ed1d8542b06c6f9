"""Parts of kernels that LLVM sees only once: in the kernel that takes them in.

Numba makes of every function a library of its own: it links in what the function calls, optimises
all that, and emits machine code. Parts are never called but inlined, so nothing of it is needed for
them. Here a part is lowered and simplified, function by
function; a kernel links in each part below it once, and is optimised and emitted as a whole.

Nor do they count who holds an array. What Python passes to a kernel lives until the kernel returns,
and kernels of the engine make no arrays; to count cost 5 % of the time of a step, and a fifth of
that to compile.

All that is private in Numba stands here: the option ``_nrt``, ``state.library`` of its compiler,
and what `RELIED_ON` names of a code library. Where a version of Numba has something else,
`compilers` gives none, and kernels are compiled as Numba does it: to other last bits, and more
slowly.
"""

from __future__ import annotations

import gc
import inspect
from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_machinery import PassManager
from numba.core.options import DefaultOptions

# What the methods of a code library use of it, by the method.
RELIED_ON = {
    "__init__": ("_linking_libraries", "_final_module", "_shared_module"),
    "finalize": ("_linking_libraries", "_final_module"),
    "_get_module_for_linking": ("_ensure_finalized", "_shared_module"),
    "add_linking_library": ("_ensure_finalized", "_linking_libraries"),
    "add_llvm_module": ("_final_module",),
    "_raise_if_finalized": ("_finalized",),
    "get_pointer_to_function": ("_ensure_finalized",),
}


def lacking() -> list[str]:
    """What this version of Numba has not that is needed here; empty if all is there."""
    found = [f"numba.core.compiler.{name}" for name in ("define_pipelines", "compile_extra")
             if not hasattr(Compiler, name)]  # fmt: skip
    found += [] if hasattr(DefaultOptions, "_nrt") else ["numba.core.options.DefaultOptions._nrt"]
    for method, names in RELIED_ON.items():
        source = inspect.getsource(getattr(JITCodeLibrary, method, lacking))
        found += [f"{name} in numba.core.codegen.JITCodeLibrary.{method}"
                  for name in names if name not in source]  # fmt: skip
    return found


def compilers() -> tuple[dict[str, Any], dict[str, Any]]:
    """Options of ``njit`` for kernels and for parts; none where `lacking` names anything."""
    if lacking():
        return {}, {}
    of_kernels, of_parts = (
        {"pipeline_class": each, "_nrt": False} for each in (KernelCompiler, PartCompiler)
    )
    return of_kernels, of_parts


class _Parts(JITCodeLibrary):
    """A part: nothing is linked, optimised or emitted."""

    def __init__(self, codegen, name):
        super().__init__(codegen, name)
        self.environments = {}

    @property
    def codegen(self):
        """What `get_executable` tells the environment to: kept for the kernel."""
        return self

    def set_env(self, name, environment):
        """Remember the environment of a function."""
        self.environments[name] = environment

    def finalize(self):
        """Nothing is left to do, but to let other modules hold the same functions."""
        self._raise_if_finalized()
        for function in self._final_module.functions:
            if not function.is_declaration:
                function.linkage = "linkonce_odr"
        self._shared_module = self._final_module
        self._finalized = True

    def get_pointer_to_function(self, name):
        """Null: there is no code of its own."""
        self._ensure_finalized()
        return 0


class _Whole(JITCodeLibrary):
    """A kernel: all parts below it are linked in, each once."""

    def finalize(self):
        """Link, optimise and emit."""
        below = dict.fromkeys(self._linking_libraries)
        found = list(below)
        for library in found:
            if isinstance(library, _Parts):
                found += [inner for inner in library._linking_libraries if inner not in below]
                below.update(dict.fromkeys(library._linking_libraries))
        self._linking_libraries = list(below)
        super().finalize()
        kept = {variable.name for variable in self._final_module.global_variables}
        for library in below:
            if isinstance(library, _Parts):
                for name in kept & set(library.environments):
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
        """Numba's passes."""
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
    """Compiler of kernels."""

    library = _Whole

    def compile_extra(self, func: Any) -> Any:
        """Compile without looking for garbage, of which there is little."""
        enabled = gc.isenabled()
        gc.disable()
        try:
            return super().compile_extra(func)
        finally:
            if enabled:
                gc.enable()
