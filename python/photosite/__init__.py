"""Photographs of scenes that exist as numbers: spectral light, electrons, raw files."""

from ._compare import Comparison, DifferencePicture, compare
from ._dataset import Dataset, Frame, FramePicture
from ._emva1288 import ChannelFigures, Emva1288Report, Figures, SpatialFigures, emva1288, emva1288_report
from ._errors import Error, FileError, InputError, PhotositeWarning, ResourceError
from ._photosite import __version__
from ._raw import Cfa, ColourCalibration, PixelArea, Raw, develop, read_raw
from ._targets import Marker, Targets, project, unproject

__all__ = [
    "Cfa",
    "ChannelFigures",
    "ColourCalibration",
    "Comparison",
    "Dataset",
    "DifferencePicture",
    "Emva1288Report",
    "Error",
    "Figures",
    "FileError",
    "Frame",
    "FramePicture",
    "InputError",
    "Marker",
    "PhotositeWarning",
    "PixelArea",
    "Raw",
    "ResourceError",
    "SpatialFigures",
    "Targets",
    "__version__",
    "compare",
    "develop",
    "emva1288",
    "emva1288_report",
    "project",
    "read_raw",
    "unproject",
]
