"""The tissue surface of a model as a mesh that moves: from rendered depth, followed by the model's motion."""
