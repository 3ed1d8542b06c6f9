"""What several terms share: random numbers, exchanges of momentum, the forces between pairs."""
