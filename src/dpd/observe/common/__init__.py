"""What several observables share: layers, averages in blocks, correlations, thermal motion."""
