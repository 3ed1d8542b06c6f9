"""Closed forms and integral equations that results are held against. Stands alone."""
