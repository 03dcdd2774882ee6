"""The claims of `compare` and its verdict, tested by runs that know nothing of the verdict's code."""
