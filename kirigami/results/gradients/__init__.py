"""How what an equilibrium tells changes with the structure: gradients by adjoint solutions."""
