"""What lies in a store."""

from pathlib import Path


def files(folder):
    """Bytes of all files by their names, but of the one that holds date and cost."""
    root = Path(folder)
    return {
        str(path.relative_to(root)): path.read_bytes()
        for path in sorted(root.rglob("*"))
        if path.is_file() and path != root / "zarr.json"
    }
