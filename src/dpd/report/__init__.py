"""Figures with one style, captions, and the page that shows all."""
