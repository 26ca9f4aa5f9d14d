"""The Jacobian of implicit methods: entries, expressions and pattern. Knows nothing of compilers, nor of solvers."""
