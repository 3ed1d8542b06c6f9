"""What is measured while a system runs: one file an observable.

A page says what it ``gives`` and how to ``measure`` that; `dpd.observe.common.measured.Measured`
keeps it in a run: series, means over blocks, correlations.

One that writes a file of its own (`Scene.files_beside`) says how it is ``opened``. That goes on
with what a former process has left (``cut``), is whole up to each checkpoint (``flush``), and takes
its place in the end (``finish``).
"""
