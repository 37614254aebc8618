"""Sheets that are given by a few numbers, and the numbers that make them do what is wanted."""
