"""List the packages: the folders that pyproject.toml maps to ``vibroscope.…``, folders that hold only data included."""

from setuptools import find_namespace_packages, setup

setup(packages=[f"vibroscope.{name}" for name in find_namespace_packages(include=["app*", "assets*", "engine*"])])
