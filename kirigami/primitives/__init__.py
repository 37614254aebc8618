"""What everything is written against: the kernel contract, model objects, nodes, materials, checks."""
