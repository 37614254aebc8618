"""What follows from results: areas, shares, averages. Nothing here solves anything."""
