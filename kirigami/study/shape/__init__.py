"""Which stable shapes a structure can take: a search, and what tells one shape from another."""
