"""The commands of the command line, one a file: ``add`` describes a command to the parser, ``run`` executes it."""

import os

# Libraries start a thread for each core, whatever VIBROSCOPE_THREADS says: OpenBLAS, for which the matrices here are
# too small, when NumPy is imported, and Zarr when it reads a store. Both read these variables when they are imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("ZARR_THREADING__MAX_WORKERS", "4")
