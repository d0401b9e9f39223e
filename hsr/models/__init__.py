"""Models of the methods' pipelines, one file a method, each stage by stage."""
