"""Path following: load control, displacement control, arc length."""
