"""Type hints: every public function has them, and they agree with each other."""

import ast

import pytest

from dpd.folders import PACKAGE, ROOT
from tests.conftest import python

# What only kernels call has no hints: Numba finds the types, and makes of each one code of its own.
FOR_KERNELS = {"kernel", "inlined", "inlined_exactly", "intrinsic_for", "overload", "part"}
FILES = sorted(PACKAGE.rglob("*.py"))


def public_functions(body):
    """Functions, and methods of classes, whose names do not begin with an underscore."""
    for node in body:
        if getattr(node, "name", "_").startswith("_"):
            continue
        if isinstance(node, ast.ClassDef):
            yield from public_functions(node.body)
        elif isinstance(node, ast.FunctionDef):
            decorators = (ast.unparse(decorator).split("(")[0] for decorator in node.decorator_list)
            if FOR_KERNELS.isdisjoint(decorators):
                yield node


def without_hint(node):
    """Names of the arguments that have no hint, and ``return``."""
    given = node.args
    arguments = [*given.posonlyargs, *given.args, *given.kwonlyargs, given.vararg, given.kwarg]
    for argument in filter(None, arguments):
        if argument.annotation is None and argument.arg not in ("self", "cls"):
            yield argument.arg
    if node.returns is None:
        yield "return"


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_public_functions_have_hints(path):
    missing = {
        f"{node.name} ({node.lineno})": names
        for node in public_functions(ast.parse(path.read_text()).body)
        if (names := list(without_hint(node)))
    }
    assert not missing


def test_hints_agree():
    """For the checker; it keeps what it has found in the folder of pytest's cache."""
    done = python("-m", "mypy", "--no-error-summary", cwd=ROOT)
    assert done.returncode == 0, done.stdout + done.stderr
