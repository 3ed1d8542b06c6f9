"""From studies and sweeps to runs: points, plans, locks, and what simulating one point means."""
