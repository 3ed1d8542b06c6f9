"""Pictures and movies of beads and bonds."""
