"""First configurations: described, placed or grown, and relaxed."""

import dpd.numba_settings  # noqa: F401
