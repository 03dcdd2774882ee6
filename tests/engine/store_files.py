"""What lies in a store."""

from pathlib import Path

from vibroscope.engine.sweeps import store_location


def files(folder):
    """Bytes of all files by their names, but of those that hold date and cost."""
    root = Path(folder)
    dated = [root / "zarr.json", root / store_location.STUDY]
    return {
        str(path.relative_to(root)): path.read_bytes()
        for path in sorted(root.rglob("*"))
        if path.is_file() and path not in dated
    }
