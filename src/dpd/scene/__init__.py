"""WHAT is simulated: the schema of a scene, its checks, and the choice of a scheme."""
