"""What people use from Python, as ``dpd.run``, ``dpd.load`` and ``dpd.sweep``."""
