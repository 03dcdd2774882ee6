"""The commands of the command line, one a file: ``add`` describes a command to the parser, ``run`` executes it."""
