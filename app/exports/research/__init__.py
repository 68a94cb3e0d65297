"""Arrays and tables for research: `model_arrays` a model over time with its depth, `tracks` where points of
the surface go."""
