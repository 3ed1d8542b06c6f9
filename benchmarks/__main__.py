"""What the benchmark alone calls, as commands: ``python -m benchmarks COMMAND``, in a clone."""

import sys
from pathlib import Path

from benchmarks import measure as module
from benchmarks.costs import observing_in
from dpd.commands import command
from dpd.commands.main import main
from dpd.files import replace_whole
from dpd.pipeline.paths import results_of
from paper_figures.benchmark.recommended import recommendations


@command("name", output="name.nc")
def measure(options):
    """Make a measurement of the benchmark."""
    module.measure(options.name, options.output, say=lambda line: print(line, flush=True))


@command("study", output="automatic.yaml")
def schemes(options):
    """Write automatic.yaml, for scheme auto, from the benchmark's figures."""
    text = recommendations(Path(results_of(options.study).figures("benchmark")))
    replace_whole(options.output, lambda draft: draft.write_text(text))


@command("study")
def observing(options):
    """Say what all that each sweep of a study observes adds to its runs."""
    observing_in(options.study)


if __name__ == "__main__":
    sys.exit(main())
