"""Figures of the papers: a package a paper, and published.yaml, every published number."""
