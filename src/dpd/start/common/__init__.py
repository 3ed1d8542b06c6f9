"""What starts share: flights of chains, growth, reading of files, relaxation."""
