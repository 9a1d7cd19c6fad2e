"""Renders scenes as a camera would record them: photons, electrons, raw images, with truth at each stage.

    import photosite as ps
    capture = ps.load("scenes/cornell-box/capture.toml", set={"exposure.time_s": 0.02})
    light = ps.trace(capture, samples=256)
    shot = light.expose(time_s=0.01, seed=3)

Arrays have rows, columns and channels in this order, are float32 or uint16, and say their units in their names. All but
the first arguments are named.
"""

from ._camera import Camera
from ._capture import Capture, load
from ._compare import Comparison, DifferencePicture, compare
from ._dataset import Dataset, Frame, FramePicture
from ._emva1288 import ChannelFigures, Emva1288Report, Figures, SpatialFigures, emva1288, emva1288_report
from ._engines.run import EngineRun
from ._errors import Error, FileError, InputError, PhotositeWarning, ResourceError
from ._fit import CameraFit, Parameter, fit
from ._light import Light, devices, render, render_into, trace
from ._photosite import __version__
from ._raw import Cfa, ColourCalibration, PixelArea, Raw, develop, read_raw
from ._rerun import to_rerun
from ._sensor import Sensor, expose
from ._shot import Layers, Shot
from ._targets import Marker, Targets, project, unproject

__all__ = [
    "Camera",
    "CameraFit",
    "Capture",
    "Cfa",
    "ChannelFigures",
    "ColourCalibration",
    "Comparison",
    "Dataset",
    "DifferencePicture",
    "Emva1288Report",
    "EngineRun",
    "Error",
    "Figures",
    "FileError",
    "Frame",
    "FramePicture",
    "InputError",
    "Layers",
    "Light",
    "Marker",
    "Parameter",
    "PhotositeWarning",
    "PixelArea",
    "Raw",
    "ResourceError",
    "Sensor",
    "Shot",
    "SpatialFigures",
    "Targets",
    "__version__",
    "compare",
    "develop",
    "devices",
    "emva1288",
    "emva1288_report",
    "expose",
    "fit",
    "load",
    "project",
    "read_raw",
    "render",
    "render_into",
    "to_rerun",
    "trace",
    "unproject",
]
