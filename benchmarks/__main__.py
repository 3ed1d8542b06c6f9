"""What the benchmark alone calls, as commands: ``python -m benchmarks COMMAND``, in a clone."""

import sys
from pathlib import Path

from benchmarks import measure as module
from benchmarks.costs import observing_in
from dpd.commands import command, option
from dpd.commands.main import main
from dpd.files import replace_whole
from dpd.pipeline.paths import results_of
from paper_figures.benchmark.recommended import recommendations


@command("name", output="name.nc")
def measure(options):
    """Make a measurement of the benchmark."""
    module.measure(options.name, options.output, say=lambda line: print(line, flush=True))


@command("study", option("--cores", type=int, default=2), output="witness.csv")
def witness(options):
    """Run a point of each sweep that LAMMPS can have on both engines, and say how they differ."""
    from benchmarks.witness import summary, witness

    rows = witness(options.study, options.cores, say=lambda line: print(line, flush=True))
    replace_whole(
        options.output, lambda draft: rows.to_csv(draft, index=False, float_format="%.6g")
    )
    text = summary(rows)
    replace_whole(options.output.with_suffix(".txt"), lambda draft: draft.write_text(text))
    print(text)


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
