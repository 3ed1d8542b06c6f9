"""A page says everything about one thing: settings, what it does, what it cannot be combined with.

It is a class in a file that is called by its key: a scene imports only the pages that it names.
Nothing at the top of a page imports Numba: kernels come with the first step.
"""

# ruff: noqa: F403
from dpd.page.base import *
from dpd.page.kinds import *
