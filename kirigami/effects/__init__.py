"""Effects beyond elements and loads; each is a file of its own and costs nothing unless it is added to a model."""
