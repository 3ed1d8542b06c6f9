"""Figures of the papers: a package a paper, and its published.yaml, all numbers it prints."""

from dpd.folders import PAPERS_DIR

if PAPERS_DIR is not None:  # figures there import their neighbours in the same way
    __path__.append(str(PAPERS_DIR))
