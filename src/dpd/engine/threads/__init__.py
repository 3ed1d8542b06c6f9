"""Threads that advance one system together, and the blocks of cells that they share."""
