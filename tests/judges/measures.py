#!/usr/bin/env python3
"""Measures images by `photosite measure` and by programs that nobody here wrote.

    measures.py PHOTOSITE PICTURE REFERENCE [MASKED.dng ...]

PHOTOSITE is the program; PICTURE and REFERENCE are two PNG files of 8 bits that differ; MASKED.dng are raw files with masked
pixels.

- PSNR and SSIM of each channel as scikit-image has them, the colour differences as colour-science does.
- Histograms and noise of raw files with masked pixels: of those that LibRaw says see light (rawpy's raw_image_visible), and
  with --masked of all.
- Numbers of TIFF, PBM, PGM and PPM files that Pillow and tifffile wrote, by what `photosite develop` makes of them.
- The transfer function of slanted edges, which are made here and blurred by a Gaussian, by quickMTF (C. Asplund's sfr),
  and by its own formula.

Exit status 0 where all is well, 1 otherwise.

Needs: pip install -r requirements.txt; pip install --no-deps quickMTF==2023.3.3, which asks for more than it uses.
"""

import json
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path

import numpy
import rawpy
import scipy.special
import skimage.metrics
import tifffile
from PIL import Image
from quickMTF.SFR_MTF import sfr_mtfcal

warnings.simplefilter("ignore")
import colour


def measured(photosite, *arguments):
    run = subprocess.run([photosite, "measure", *map(str, arguments), "--json"], capture_output=True, text=True, check=True)
    return json.loads(run.stdout)


def judge_likeness(photosite, a, b):
    found = measured(photosite, "similarity", a, b)
    first, second = (numpy.asarray(Image.open(path).convert("RGB"), float) / 255 for path in (a, b))
    for channel, (x, y) in zip(found["channels"], zip(first.transpose(2, 0, 1), second.transpose(2, 0, 1))):
        psnr = skimage.metrics.peak_signal_noise_ratio(y, x, data_range=1)
        ssim = skimage.metrics.structural_similarity(
            y, x, data_range=1, gaussian_weights=True, sigma=1.5, use_sample_covariance=False, full=True
        )[1]
        # scikit-image leaves out a frame of the window's radius when it takes the mean, as photosite does.
        ssim = ssim[5:-5, 5:-5].mean()
        print(f"{channel['channel']}: PSNR {channel['psnr_db']:.6f} dB here, {psnr:.6f} there; SSIM {channel['ssim']:.8f} and {ssim:.8f}")
        # Both compute from the same codes in double precision.
        if abs(channel["psnr_db"] - psnr) > 1e-9:
            yield f"PSNR of {channel['channel']} is {channel['psnr_db']}, {psnr} by scikit-image"
        if abs(channel["ssim"] - ssim) > 1e-9:
            yield f"SSIM of {channel['channel']} is {channel['ssim']}, {ssim} by scikit-image"
    white = numpy.array([0.3127, 0.3290])
    lab = lambda codes: colour.XYZ_to_Lab(colour.RGB_to_XYZ(codes, "sRGB", apply_cctf_decoding=True), white)
    difference = colour.delta_E(lab(second), lab(first), method="CIE 2000").mean()
    print(f"mean delta E 2000 {found['mean_delta_e_2000']:.5f} here, {difference:.5f} by colour-science")
    # Their matrix to XYZ is rounded to four digits and so is their white.
    if abs(found["mean_delta_e_2000"] / difference - 1) > 2e-3:
        yield f"mean delta E 2000 is {found['mean_delta_e_2000']}, {difference} by colour-science"


def judge_masked(photosite, path):
    with rawpy.imread(str(path)) as raw:
        visible, whole = raw.raw_image_visible.astype(float), raw.raw_image.astype(float)
        colours = raw.raw_colors_visible.copy()
    if visible.shape == whole.shape:
        yield f"{path}: LibRaw sees no masked pixels"
    for numbers, option in [(visible, []), (whole, ["--masked"])]:
        found = measured(photosite, "histogram", path, *option)[0]
        print(f"{path.parent.name} {option}: mean {found['mean']:.6f}, sigma {found['standard_deviation']:.6f}; {numbers.mean():.6f}, {numbers.std():.6f} by LibRaw")
        # The same whole numbers, summed in double precision.
        if abs(found["mean"] - numbers.mean()) > 1e-6 or abs(found["standard_deviation"] - numbers.std()) > 1e-6:
            yield f"{path} {option}: mean and sigma {found['mean']}, {found['standard_deviation']}; {numbers.mean()}, {numbers.std()} by LibRaw"
    command = [photosite, "noise", path, "--lags", "0", "--patch", "12,8,60,40", "--json"]
    planes = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)["planes"]
    side = round(len(planes) ** 0.5)
    for i, plane in enumerate(planes):
        # Places of the tile, counted from the corner of what sees light.
        place = (slice(8 + i // side, 48, side), slice(12 + i % side, 72, side))
        numbers, letters = visible[place], colours[place]
        if abs(plane["mean"] - numbers.mean()) > 1e-6 or abs(plane["uniform"]["sigma"] - numbers.std(ddof=1)) > 1e-6:
            yield f"{path}: {plane['name']} is {plane['mean']}, {plane['uniform']['sigma']}; {numbers.mean()}, {numbers.std(ddof=1)} by LibRaw"
        # It takes tiles of four columns for Bayer's, and its second green is a colour of its own.
        if side <= 2 and (numpy.unique(letters).size != 1 or (side > 1 and "RGBG"[letters[0, 0]] != plane["name"][0])):
            yield f"{path}: {plane['name']} are LibRaw's colours {numpy.unique(letters)}"


def judge_numbers(photosite, scratch):
    random = numpy.random.default_rng(5)
    grey, colour = random.integers(0, 256, (13, 21), numpy.uint8), random.integers(0, 256, (13, 21, 3), numpy.uint8)
    deep = random.integers(0, 65536, (13, 21, 3), numpy.uint16)
    bits = random.integers(0, 2, (13, 21)).astype(bool)
    words = lambda array: " ".join(map(str, array.ravel()))
    files = {}
    for name, array, white in [("grey.tif", grey, 255), ("colour.tif", colour, 255), ("deep.tif", deep, 65535)]:
        tifffile.imwrite(scratch / name, array, photometric="minisblack" if array.ndim == 2 else "rgb")
        files[name] = array / white
    tifffile.imwrite(scratch / "planes.tif", colour.transpose(2, 0, 1), photometric="rgb", planarconfig="separate")
    Image.fromarray(colour).save(scratch / "lzw.tif", compression="tiff_lzw")
    Image.fromarray(colour).save(scratch / "deflate.tif", compression="tiff_adobe_deflate")
    files |= {"planes.tif": colour / 255, "lzw.tif": colour / 255, "deflate.tif": colour / 255}
    Image.fromarray(grey).save(scratch / "grey.pgm")
    Image.fromarray(colour).save(scratch / "colour.ppm")
    Image.fromarray(bits).save(scratch / "bits.pbm")
    (scratch / "text.pgm").write_text(f"P2\n# grey\n21 13\n255\n{words(grey)}\n")
    (scratch / "text.ppm").write_text(f"P3 21 13 65535\n{words(deep)}")
    (scratch / "text.pbm").write_text(f"P1 21 13\n{words(1 - bits.astype(int))}")
    files |= {"grey.pgm": grey / 255, "colour.ppm": colour / 255, "bits.pbm": bits, "text.pgm": grey / 255, "text.ppm": deep / 65535, "text.pbm": bits}
    for name, expected in files.items():
        linear = ["--set", "develop.tone_curve=linear", "--set", "develop.bits=16"]
        command = [photosite, "develop", scratch / name, "-o", scratch / "linear.tiff", "--force", "--quiet", *linear]
        subprocess.run(command, check=True)
        found = tifffile.imread(scratch / "linear.tiff")
        off = numpy.abs(found / 65535 - expected).max()
        print(f"{name}: linear light off by {off:.1e}")
        # Rounded to 16 bits, and that of 32-bit floats.
        if found.shape != expected.shape or off > 0.51 / 65535:
            yield f"{name} is off by {off}"


def edge(angle, sigma, width=96, height=120, points=16):
    """A Gaussian edge, averaged over the area of each pixel."""
    part = (numpy.arange(points) + 0.5) / points - 0.5
    x = (numpy.arange(width)[:, None] + part).ravel() - width / 2 + 0.2
    y = (numpy.arange(height)[:, None] + part).ravel() - height / 2
    angle = numpy.radians(angle)
    values = scipy.special.ndtr((x * numpy.cos(angle) - y[:, None] * numpy.sin(angle)) / sigma)
    return 0.1 + 0.7 * values.reshape(height, points, width, points).mean(axis=(1, 3))


def judge_edges(photosite, scratch):
    for angle, sigma in [(5, 0.3), (-5, 0.5), (8, 0.7), (11, 1.0)]:
        path = scratch / "edge.tiff"
        codes = numpy.round(edge(angle, sigma) * 65535).astype(numpy.uint16)
        tifffile.imwrite(path, numpy.stack([codes] * 3, axis=2), photometric="rgb")
        found = measured(photosite, "mtf", path, "--linear")
        frequency, ours = numpy.array(found["frequency_cy_per_px"]), numpy.array(found["mtf"])
        kept = frequency <= 0.5
        frequency, ours = frequency[kept], ours[kept]
        cos, sin = numpy.cos(numpy.radians(angle)), numpy.sin(numpy.radians(angle))
        truth = numpy.exp(-2 * (numpy.pi * sigma * frequency) ** 2) * numpy.sinc(frequency * cos) * numpy.sinc(frequency * sin)
        theirs, _ = sfr_mtfcal().calc_sfr(codes / 65535, oversampling=4)
        # It does not put back what its bins of a quarter of a pixel and its differences over two of them take.
        theirs = numpy.interp(frequency, theirs[:, 0], theirs[:, 1]) / numpy.sinc(frequency / 2) / numpy.sinc(frequency / 4)
        from_truth, from_theirs = numpy.abs(ours - truth).max(), numpy.abs(ours - theirs).max()
        print(f"edge of {angle} degrees, sigma {sigma}: MTF differs by {from_truth:.4f} from the formula, {from_theirs:.4f} from quickMTF")
        # Where the pixels of a bin lie on average is off its middle by up to a tenth of its width.
        if from_truth > 0.01:
            yield f"MTF of an edge of {angle} degrees, sigma {sigma}: {from_truth} from the formula"
        # Its window, about 1.5 times as wide as the line is at a tenth of its height, narrows a Gaussian by 5 %, which
        # raises the modulation by up to 0.04.
        if from_theirs > 0.05:
            yield f"MTF of an edge of {angle} degrees, sigma {sigma}: {from_theirs} from quickMTF"


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    photosite, a, b, *masked = sys.argv[1:]
    with tempfile.TemporaryDirectory() as scratch:
        complaints = [*judge_likeness(photosite, a, b), *judge_edges(photosite, Path(scratch)), *judge_numbers(photosite, Path(scratch))]
    for path in map(Path, masked):
        complaints += judge_masked(photosite, path)
    for complaint in complaints:
        print(complaint, file=sys.stderr)
    sys.exit(1 if complaints else 0)


if __name__ == "__main__":
    main()
