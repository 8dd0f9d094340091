"""Training grasp networks on rendered images, and how good they are."""
