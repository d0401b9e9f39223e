"""What methods make ready of a view before their kernels run."""
