"""The commands of the command line, one a file: ``add`` describes it to the parser, ``run`` does it."""
