"""Analyses: they drive an assembled system and know no element."""
