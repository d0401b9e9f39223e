"""One file a method; all answer the same question on the same view."""
