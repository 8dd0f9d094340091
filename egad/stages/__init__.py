"""One module a stage: read its inputs, call the library, write its outputs."""
