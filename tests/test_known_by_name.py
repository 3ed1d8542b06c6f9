"""No term or observable is known by name outside of its page, but where this says so."""

import ast

from dpd.folders import PACKAGE
from dpd.page import Observable, Term, names

ROOMS = ("api", "commands", "engine", "files.py", "page", "pipeline", "runs", "scene", "start")
KEYS = {*names(Term), *names(Observable)}
# What every scene has, its repulsion, thermostat and integrator, is known to all. The rest is to
# become less: where a file knows a page that does not stand here, give pages a hook.
KNOWN = {
    "engine/beads.py": {"walls"},  # arguments of kernels
    "engine/forces.py": {"bonds", "many_body"},
    "engine/crossings.py": {"crossings"},  # a word of messages
    "pipeline/sweep.py": {"pressure"},  # variables of results
    "pipeline/status.py": {"pressure"},
    "runs/result.py": {"pressure"},
    "scene/reading.py": {"bonds"},  # a key of molecules
    "scene/sections.py": {"thermo"},  # the observable of a scene that names none
    "start/common/make.py": {"angle", "bond", "pair"},  # fields of the engine's system
}
OF_ALL = {"integrator", "repulsion", "thermostat"}


def texts(path):
    """All strings in a file's code but docstrings."""
    tree = ast.parse(path.read_text())
    told = {
        id(node.body[0].value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(node)
    }
    nodes = (node for node in ast.walk(tree) if isinstance(node, ast.Constant))
    return {node.value for node in nodes if isinstance(node.value, str) and id(node) not in told}


FILES = sorted(
    path for room in ROOMS
    for path in ([PACKAGE / room] if room.endswith(".py") else (PACKAGE / room).rglob("*.py"))
)  # fmt: skip


def test_pages_are_known_by_what_they_say():
    """No file has other names than it is known for, and it has those."""
    found = {str(path.relative_to(PACKAGE)): texts(path) & (KEYS - OF_ALL) for path in FILES}
    assert {file: known for file, known in found.items() if known} == KNOWN
