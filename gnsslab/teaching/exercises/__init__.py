"""The exercises of the course: one file a lesson, with its PREDICTION and its QUESTIONS."""
