"""What observers ask of all beads and pairs: distances, stress, waves, bonds that cross or pass."""
