#!/usr/bin/env python3
"""Develops photosite's raw files with LibRaw, dcraw, RawTherapee and darktable and compares the colours with photosite's
own.

    developed_colours.py FOLDER...

Each FOLDER, whose name ends with that of the light (D65, D50 or A), holds raw.dng, image.png and wide.tiff (linear
Rec. 2020, 16 bits) of a noise-free colour checker of 6 x 4 patches. It fills the image, or, where there is a capture.json
beside, it is that of scenes/colour-checker as its camera sees it.

- In D65, for which alone LibRaw has a matrix, image.png is compared with its image in blocks of 16 x 16 pixels whose
  content is even, so that edges, at which demosaicking differs, do not count. Traced images have no such blocks.
- The patches are compared with what the observer sees, computed by the colour-science package, and with the best that
  any matrix of 3 x 3 numbers makes of the camera's channels: photosite may be 0.1 worse in the mean delta E 2000 in all
  lights; the others, which use the matrix for D65 alone, 0.1 in D65 and 1.4 in D50.

Of sensors that have all channels at every pixel, whose responses overlap so far that white itself would be sacrificed
for other colours, the best matrix is the best of those that keep white. Their colours pass what dcraw, RawTherapee and
darktable do not cut off, so only LibRaw is asked.

Exit status 0 where all is well, 1 otherwise.

Needs: pip install -r requirements.txt, apt-get install dcraw rawtherapee darktable.
"""

import json
import struct
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path

import numpy
import rawpy
import scipy.optimize
import tifffile
from PIL import Image

warnings.simplefilter("ignore")
import colour

BLOCK = 16
# Both round to 8 bits once, after computing in single precision or 16-bit integers: one code each.
TOLERANCE = 2.0
# A block counts as even where no channel varies more than this.
EVEN = 6.0


def blocks(picture):
    height, width = (n // BLOCK * BLOCK for n in picture.shape[:2])
    cut = picture[:height, :width].astype(float)
    tiles = cut.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3).swapaxes(1, 2)
    return tiles.reshape(-1, BLOCK * BLOCK, 3)


CHECKER = colour.SDS_COLOURCHECKERS["ISO 17321-1"]
LIGHTS = {"D65": colour.SDS_ILLUMINANTS["D65"], "D50": colour.SDS_ILLUMINANTS["D50"], "A": colour.SDS_ILLUMINANTS["A"]}
# Most that a developer may be worse than the best matrix, mean delta E 2000.
OURS = {"D65": 0.1, "D50": 0.1, "A": 0.1}
OTHERS = {"D65": 0.1, "D50": 1.4}

# Nothing but white balance, matrix and a colour space wide enough for every patch.
RAWTHERAPEE = """[Version]
AppVersion=5.9
Version=349
[Exposure]
Auto=false
HistogramMatching=false
ClampOOG=false
[HLRecovery]
Enabled=false
[White Balance]
Setting=Camera
[Color Management]
InputProfile=(camera)
ToneCurve=false
ApplyLookTable=false
ApplyBaselineExposureOffset=false
ApplyHueSatMap=false
WorkingProfile=ProPhoto
OutputProfile=RTv4_Rec2020
OutputBPC=false
[Sharpening]
Enabled=false
[PostDemosaicSharpening]
Enabled=false
[LensProfile]
LcMode=none
"""
DARKTABLE = ["workflow=none", "chromatic-adaptation=legacy", "sharpen/auto_apply=false"]


def tristimulus(light, reflectance=None):
    """XYZ of a reflectance in a light, relative to that of white."""
    shape = colour.SpectralShape(360, 830, 1)
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(shape)
    hold = {"method": "Constant", "left": None, "right": None}
    power = light.copy().align(shape, extrapolator_kwargs={"method": "Constant", "left": 0, "right": 0}).values
    if reflectance is not None:
        linear = {"interpolator": colour.LinearInterpolator}
        power = power * reflectance.copy().align(shape, **linear, extrapolator_kwargs=hold).values
    return observer.values.T @ power


def chart(folder: Path, picture, size):
    """The part of an image that the cells of the chart fill, 46 mm each; `size` is that of a whole image, of which a
    developer may leave out a frame."""
    path = folder / "capture.json"
    if not path.exists():
        return picture
    report = json.loads(path.read_text())
    (fx, _, cx), (_, fy, cy), _ = report["camera"]["camera_matrix"]
    distance = report["capture"]["camera"]["position_m"][2]
    left, top = ((whole - there) // 2 for whole, there in zip(size[::-1], picture.shape[1::-1]))
    x, y = 3 * 0.046 * fx / distance, 2 * 0.046 * fy / distance
    # The matrix counts from the middle of a pixel.
    edge = lambda middle, half, first: round(middle + 0.5 + half - first)
    return picture[edge(cy, -y, top) : edge(cy, y, top), edge(cx, -x, left) : edge(cx, x, left)]


def patches(picture):
    """Mean of the middle of each patch."""
    height, width = picture.shape[0] // 4, picture.shape[1] // 6
    middle = lambda y, x: picture[y * height + height // 3 : (y + 1) * height - height // 3, x * width + width // 3 : (x + 1) * width - width // 3]
    return numpy.array([middle(i // 6, i % 6).reshape(-1, picture.shape[2]).mean(axis=0) for i in range(24)])


def by_profile(path: Path):
    """XYZ under D50 of a TIFF file, by its ICC profile of a matrix and one curve."""
    with tifffile.TiffFile(path) as file:
        codes = file.pages[0].asarray()
        profile = file.pages[0].tags[34675].value
    codes = codes / 65535 if codes.dtype == numpy.uint16 else codes.astype(float)
    entries = [struct.unpack(">4sII", profile[132 + 12 * i : 144 + 12 * i]) for i in range(struct.unpack(">I", profile[128:132])[0])]
    tags = {name: profile[start : start + length] for name, start, length in entries}
    fixed = lambda data: numpy.array(struct.unpack(f">{len(data) // 4}i", data)) / 65536
    to_xyz = numpy.array([fixed(tags[name][8:20]) for name in (b"rXYZ", b"gXYZ", b"bXYZ")])
    curve = tags[b"rTRC"]
    if curve[:4] == b"curv" and int.from_bytes(curve[8:12]) <= 1:
        # A power with eight bits behind the point, or none at all.
        return codes ** (int.from_bytes(curve[12:14]) / 256 if int.from_bytes(curve[8:12]) else 1) @ to_xyz
    if curve[:4] != b"para":
        raise ValueError(f"{path}: a curve of the kind {curve[:4]}")
    count = [1, 3, 4, 5, 7][struct.unpack(">H", curve[8:10])[0]]
    g, a, b, c, d, e, f = numpy.pad(fixed(curve[12 : 12 + 4 * count]), (0, 7 - count))
    return numpy.where(codes >= d, numpy.maximum(a * codes + b, 0) ** g + e, c * codes + f) @ to_xyz


def developed_elsewhere(raw: Path):
    """XYZ under D50 or D65, by the name of the program, with whether it is D50."""
    dcraw = subprocess.run(["dcraw", "-c", "-w", "-W", "-4", "-o", "5", "-t", "0", str(raw)], capture_output=True, check=True).stdout
    _, size, _, pixels = dcraw.split(b"\n", 3)
    width, height = map(int, size.split())
    yield "dcraw", numpy.frombuffer(pixels, ">u2").reshape(height, width, 3) / 65535, False
    with tempfile.TemporaryDirectory() as scratch:
        scratch = Path(scratch)
        (scratch / "neutral.pp3").write_text(RAWTHERAPEE)
        commands = {
            "RawTherapee": ["rawtherapee-cli", "-q", "-Y", "-o", scratch / "RawTherapee.tif", "-p", scratch / "neutral.pp3", "-b16", "-t", "-c", raw],
            "darktable": ["darktable-cli", raw, scratch / "darktable.tif", "--icc-type", "LIN_REC2020"]
            + ["--core", "--library", ":memory:", "--configdir", scratch / "darktable", "--conf", "plugins/imageio/format/tiff/bpp=32"]
            + [part for setting in DARKTABLE for part in ("--conf", f"plugins/darkroom/{setting}")],
        }
        for name, command in commands.items():
            run = subprocess.run([str(part) for part in command], capture_output=True, text=True)
            picture = scratch / f"{name}.tif"
            if not picture.exists():
                raise RuntimeError(f"{name} develops nothing: {run.stdout[-300:]} {run.stderr[-300:]}")
            yield name, by_profile(picture), True


def judge_patches(folder: Path):
    name = folder.name.rsplit("-", 1)[1]
    light = LIGHTS[name]
    white, d65 = tristimulus(light), tristimulus(LIGHTS["D65"])
    seen = numpy.array([tristimulus(light, patch) for patch in CHECKER.values()]) / white[1]
    white, d65 = white / white[1], d65 / d65[1]
    adapted = seen @ colour.adaptation.matrix_chromatic_adaptation_VonKries(white, d65, transform="Bradford").T
    lab = lambda xyz: colour.XYZ_to_Lab(xyz, d65[:2] / d65.sum())
    reference = lab(adapted)
    # Exposures differ, colours must not: each is brought to the luminance of the chart.
    scaled = lambda xyz: xyz * (adapted[:, 1] @ xyz[:, 1] / (xyz[:, 1] @ xyz[:, 1]))
    error = lambda xyz: colour.delta_E(reference, lab(scaled(xyz)), method="CIE 2000").mean()

    with rawpy.imread(str(folder / "raw.dng")) as raw:
        planes = raw.raw_image_visible.astype(float) - raw.black_level_per_channel[0]
        is_full = planes.ndim == 3
        if not is_full:
            # LibRaw numbers the second green 3.
            colours = numpy.where(raw.raw_colors_visible == 3, 1, raw.raw_colors_visible)
            planes = numpy.stack([numpy.where(colours == c, planes, numpy.nan) for c in (0, 1, 2)], axis=2)
        planes = planes[:, :, :3] * numpy.array(raw.camera_whitebalance[:3])
        theirs = raw.postprocess(
            use_camera_wb=True,
            no_auto_bright=True,
            adjust_maximum_thr=0.0,
            output_color=rawpy.ColorSpace.XYZ,
            gamma=(1, 1),
            output_bps=16,
            user_flip=0,
        )
    size = planes.shape[:2]
    whole = lambda picture: chart(folder, picture, size)
    planes = whole(planes)
    height, width = planes.shape[0] // 4, planes.shape[1] // 6
    cut = lambda i: planes[i // 6 * height + height // 4 : (i // 6 + 1) * height - height // 4, i % 6 * width + width // 4 : (i % 6 + 1) * width - width // 4]
    camera = numpy.array([numpy.nanmean(cut(i).reshape(-1, 3), axis=0) for i in range(24)])
    camera /= camera.max()
    search = lambda matrix, start: scipy.optimize.minimize(
        lambda m: error(camera @ matrix(m)), start, method="Powell", options={"maxfev": 20000, "xtol": 1e-5, "ftol": 1e-7}
    )
    start = numpy.linalg.lstsq(camera / adapted[:, 1:2], adapted / adapted[:, 1:2], rcond=None)[0]
    found = search(lambda m: m.reshape(3, 3), start.ravel())
    if is_full:
        # The channels of white are equal, so that the rows of a matrix that keeps it have the sum of white.
        keeping = lambda m: numpy.vstack([m.reshape(2, 3), d65 - m.reshape(2, 3).sum(axis=0)])
        start = found.x.reshape(3, 3)
        found = search(keeping, (start * d65 / start.sum(axis=0))[:2].ravel())
    best = found.fun
    to_xyz = colour.normalised_primary_matrix(colour.RGB_COLOURSPACES["ITU-R BT.2020"].primaries, d65[:2] / d65.sum())
    ours = error(patches(whole(tifffile.imread(folder / "wide.tiff").astype(float))) @ to_xyz.T)
    others = {"LibRaw": error(patches(whole(theirs.astype(float))))}
    if name in OTHERS and not is_full:
        from_d50 = colour.adaptation.matrix_chromatic_adaptation_VonKries(numpy.array([0.9642, 1.0, 0.8249]), d65, transform="Bradford")
        for program, picture, is_d50 in developed_elsewhere(folder / "raw.dng"):
            picture = whole(picture)
            others[program] = error(patches(picture @ from_d50.T if is_d50 else picture))
    figures = ", ".join(f"{value:.3f} by {program}" for program, value in others.items())
    print(f"{folder.name}: mean delta E 2000 {ours:.3f} here, {figures}, {best:.3f} by the best matrix")
    if ours > best + OURS[name]:
        yield f"{folder}: mean delta E 2000 of {ours:.3f}, {best:.3f} would be possible"
    for program, value in others.items():
        if name in OTHERS and value > best + OTHERS[name]:
            yield f"{folder}: {program} reaches a mean delta E 2000 of {value:.3f}, {best:.3f} would be possible"


def judge_picture(folder: Path):
    if not folder.name.endswith("-D65") or (folder / "capture.json").exists():
        return []
    ours = numpy.asarray(Image.open(folder / "image.png").convert("RGB"))
    with rawpy.imread(str(folder / "raw.dng")) as raw:
        # Of images with several values per pixel, LibRaw takes the white level above 0 and not above black.
        is_full = raw.raw_image.ndim == 3
        theirs = raw.postprocess(
            user_sat=raw.white_level - raw.black_level_per_channel[0] if is_full else None,
            use_camera_wb=True,
            no_auto_bright=True,
            adjust_maximum_thr=0.0,
            output_color=rawpy.ColorSpace.sRGB,
            gamma=(2.4, 12.92),
            user_flip=0,
        )
    if ours.shape != theirs.shape:
        return [f"{folder}: image.png is {ours.shape}, LibRaw's {theirs.shape}"]
    our_blocks, their_blocks = blocks(ours), blocks(theirs)
    even = (numpy.ptp(our_blocks, axis=1).max(axis=1) <= EVEN) & (numpy.ptp(their_blocks, axis=1).max(axis=1) <= EVEN)
    if not even.any():
        return [f"{folder}: no even block to compare"]
    difference = numpy.abs(our_blocks[even].mean(axis=1) - their_blocks[even].mean(axis=1))
    print(f"{folder}: {even.sum()} blocks, mean difference {difference.mean():.3f} codes, largest {difference.max():.3f}")
    if difference.max() > TOLERANCE:
        worst = difference.max(axis=1).argmax()
        ours_there, theirs_there = our_blocks[even][worst].mean(axis=0), their_blocks[even][worst].mean(axis=0)
        return [f"{folder}: colours differ by {difference.max():.2f} codes: {ours_there} here, {theirs_there} by LibRaw"]
    return []


def main():
    folders = [Path(argument) for argument in sys.argv[1:]]
    if not folders:
        sys.exit(__doc__)
    complaints = [complaint for folder in folders for judge in (judge_picture, judge_patches) for complaint in judge(folder)]
    for complaint in complaints:
        print(complaint, file=sys.stderr)
    sys.exit(1 if complaints else 0)


if __name__ == "__main__":
    main()
