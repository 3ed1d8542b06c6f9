"""LAMMPS as a second engine: any scene whose terms have lines there, on many processes by MPI."""
