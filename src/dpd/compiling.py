"""How long this process has compiled kernels, and who hears that it begins to."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from numba.core import event

if TYPE_CHECKING:
    from collections.abc import Callable


class _Compiling(event.Listener):
    """How long kernels took to compile in this process, and who is told that one begins to."""

    def __init__(self) -> None:
        self.seconds = 0.0
        self.tell: Callable[[str], None] | None = None
        self._depth = self._since = 0.0  # a kernel's parts compile while it does

    def on_start(self, event: event.Event) -> None:
        """A function begins to compile."""
        if not self._depth:
            self._since = time.perf_counter()
            if self.tell:
                self.tell("compiling, once for this kind of scene")
            self.tell = None
        self._depth += 1

    def on_end(self, event: event.Event) -> None:
        """It is compiled."""
        self._depth -= 1
        if not self._depth:
            self.seconds += time.perf_counter() - self._since


COMPILING = _Compiling()
event.register("numba:compile", COMPILING)
