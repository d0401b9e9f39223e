"""What is in the world: the model, the generic shapes, the files."""
