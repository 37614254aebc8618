"""From a cut drawing to a verified triangle mesh."""
