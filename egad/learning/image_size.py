"""The size of the images that networks take, in a module that loads nothing else."""

SIZE = 300  # pixels along each side of the image that goes in, and of those that come out
