"""The sections of the HTML report, with their charts and templates; pictures, the 3D viewer."""
