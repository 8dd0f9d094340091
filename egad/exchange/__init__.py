"""Files that other programs read and write: one module per format, and meshes of any format."""
