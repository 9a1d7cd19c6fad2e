"""Photographs of scenes that exist as numbers: spectral light, electrons, raw files."""

from ._errors import Error, FileError, InputError, PhotositeWarning, ResourceError
from ._photosite import __version__
from ._raw import Cfa, ColourCalibration, PixelArea, Raw, develop, read_raw

__all__ = ["Error", "FileError", "InputError", "PhotositeWarning", "ResourceError", "__version__"]
