"""What the engine costs, and what that buys: speed, accuracy, stability."""
