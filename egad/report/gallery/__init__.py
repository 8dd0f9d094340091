"""The gallery: a static site with the map of a dataset and a page for each object."""
