"""What is measured while a system runs: one file an observable.

A page says what it ``gives`` and how to ``measure`` that; `dpd.observe.common.measured.Measured`
keeps it in a run. A file of its own that it has ``opened`` goes on with what a former process has
left (``cut``), is whole up to each checkpoint (``flush``), and takes its place (``finish``).
"""
