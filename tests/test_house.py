"""The house stays small: its lines, files and imports are counted, and run in no circle."""

import ast
from graphlib import TopologicalSorter

from dpd.digest import PACKAGE, ROOT

LINES, FILES, TESTS, PAPERS = 24_450, 144, 16_500, 15_000  # at most; lower them with the house
LONGEST = 450  # lines of a file
SMALL = 60  # lines of a module that has more than one user
PAGES = ("observe", "physics", "start")  # folders whose files are pages, which nobody imports

MODULES = {
    ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__"): path
    for path in sorted(PACKAGE.rglob("*.py"))
}
LENGTHS = {name: path.read_text().count("\n") for name, path in MODULES.items()}


def lines_of(*folders):
    """Lines of all Python files below some folders of the repository."""
    paths = [path for folder in folders for path in (ROOT / folder).rglob("*.py")]
    return sum(path.read_text().count("\n") for path in paths)


def imported(path):
    """Modules of the package that a file imports, also for types, also in functions."""
    for node in ast.walk(ast.parse(path.read_text())):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        for name in names:
            while name and name not in MODULES:
                name = name.rpartition(".")[0]
            if name:
                yield name


IMPORTS = {name: set(imported(path)) - {name} for name, path in MODULES.items()}


def test_it_does_not_grow():
    """Where a line more buys a user something, find one that does not."""
    assert sum(LENGTHS.values()) <= LINES and len(MODULES) <= FILES
    assert lines_of("tests") <= TESTS
    assert lines_of("paper_figures", "rules", "benchmarks") <= PAPERS
    assert {name for name, lines in LENGTHS.items() if lines > LONGEST} == set()


def test_imports_run_in_no_circle():
    """Those for types included."""
    list(TopologicalSorter(IMPORTS).static_order())


def test_no_small_module_has_one_user():
    """It stands in its user."""
    users = {name: [user for user, used in IMPORTS.items() if name in used] for name in MODULES}
    lonely = {
        name for name, path in MODULES.items()
        if LENGTHS[name] < SMALL and len(users[name]) == 1 and path.name != "__init__.py"
        and path.parent.name not in PAGES
    }  # fmt: skip
    assert lonely == set()
