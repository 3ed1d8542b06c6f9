"""Figures of the papers: a package a paper, and its published.yaml, all numbers it prints."""
