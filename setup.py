"""Which packages there are: those in the folders that pyproject.toml maps to ``vibroscope.…``."""

from setuptools import find_packages, setup

setup(packages=[f"vibroscope.{name}" for name in find_packages(include=["app*", "assets*", "engine*"])])
