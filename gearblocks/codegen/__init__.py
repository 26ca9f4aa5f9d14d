"""From the tables to C. Knows nothing of compilers, nor of solvers."""
