"""What comes out of an analysis: steps, results, their files, stress and fields."""
