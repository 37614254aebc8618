"""In-plane mechanisms: tilings, bar frameworks, periodic cells, Bloch waves."""
