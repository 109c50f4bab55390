"""Packages that a module needs only where it is used."""

from importlib import import_module
from typing import Any


def need(module: str, package: str, purpose: str) -> Any:
    """The module. Raises ImportError with the name of the package that has it."""
    try:
        return import_module(module)
    except ImportError as error:
        raise ImportError(f"{purpose} needs {module}: pip install {package}") from error
