"""Photographs of scenes that exist as numbers: spectral light, electrons, raw files."""

from ._errors import Error, FileError, InputError, PhotositeWarning, ResourceError
from ._photosite import __version__

__all__ = ["Error", "FileError", "InputError", "PhotositeWarning", "ResourceError", "__version__"]
