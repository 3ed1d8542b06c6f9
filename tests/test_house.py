"""The house stays small: its lines, files and imports are counted, and run in no circle."""

from graphlib import TopologicalSorter

from dpd.folders import ROOT
from tests.test_imports import MODULES, imported

LINES, FILES, TESTS, PAPERS, DOCS = 22_721, 140, 16_000, 15_500, 600  # at most
LONGEST = 450  # lines of a file
SMALL = 60  # lines of a module that has more than one user
PAGES = ("observe", "physics", "start")  # folders whose files are pages, which nobody imports

LENGTHS = {name: path.read_text().count("\n") for name, path in MODULES.items()}


def files_of(*folders):
    """All Python files below some folders of the repository."""
    return [path for folder in folders for path in (ROOT / folder).rglob("*.py")]


def lines_of(*folders):
    """Their lines."""
    return sum(path.read_text().count("\n") for path in files_of(*folders))


def modules(path):
    """Modules of the package that a file imports, also for types, also in functions."""
    for name in imported(path):
        while name and name not in MODULES:
            name = name.rpartition(".")[0]
        yield name


IMPORTS = {name: {*modules(path)} - {name, ""} for name, path in MODULES.items()}


def test_it_does_not_grow():
    """Where a line more buys a user something, find one that does not."""
    assert lines_of("src/dpd") <= LINES and len(files_of("src/dpd")) <= FILES
    assert lines_of("tests") <= TESTS
    assert lines_of("paper_figures", "rules", "benchmarks") <= PAPERS
    assert lines_of("docs") <= DOCS
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
