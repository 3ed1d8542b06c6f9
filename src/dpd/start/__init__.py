"""First configurations: described, placed or grown, and relaxed."""
