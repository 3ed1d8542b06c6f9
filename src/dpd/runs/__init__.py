"""What runs a scene: from its first configuration to run.nc, alone, stopped and resumed."""
