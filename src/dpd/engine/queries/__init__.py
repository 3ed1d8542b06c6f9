"""What observers ask of all pairs: distances, crossings and passes of bonds, curvature."""
