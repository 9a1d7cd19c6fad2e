#!/usr/bin/env python3
"""Reads photosite's raw files back with programs that nobody here wrote.

    raw_files.py [--developers] FOLDER...

Each FOLDER holds raw.dng and raw.tiff, and may hold raw.pgm and raw.npy of the same image. Adobe's DNG SDK (through
dngpy), LibRaw (through rawpy), dcraw and tifffile must find the very same digital numbers in the DNG as tifffile does in
the TIFF; LibRaw and dcraw those that the table of capture.json makes of them where a sensor is not linear. LibRaw must
find the same black level, white level, colour filter array and colour matrix as exiftool finds in the tags; exiftool must
find nothing to warn about. With --developers, RawTherapee and darktable must develop the DNG to an image of the right
size. Where the folder holds a capture.json too, the tags must say the exposure, lens and levels that it says.
Exit status 0 where all is well, 1 otherwise.

What these programs cannot do is not asked of them: dcraw knows no floating-point numbers, which is what Deflate holds;
LibRaw scales those to a range of its own; neither knows tiles of other sizes than 2 x 2 and 6 x 6. Nor are they asked
for what they do otherwise on purpose, which is said where it is left out.

Needs: pip install -r requirements.txt, apt-get install libimage-exiftool-perl dcraw rawtherapee darktable.
"""

import contextlib
import json
import math
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import dngpy
import numpy
import rawpy
import tifffile

CFA_LETTERS = "RGBCMYW"
DEFLATE = 8
# Tags that versions of exiftool before 13 know, but not as standard: CalibrationIlluminant3 and the matrices of that light.
DNG_1_6_TAGS = ("tag 0xcd31", "tag 0xcd32", "tag 0xcd33", "tag 0xcd34")
# EXIF's number for D65 as a light source.
D65 = 21
# RawTherapee leaves out a frame whose pixels have too few neighbours.
RAWTHERAPEE_FRAME = 8

# IEC 61966-2-1, as LibRaw has it.
SRGB_TO_XYZ = numpy.array([[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]])


@contextlib.contextmanager
def silence():
    """No warnings that pixels at the very edge are shown."""
    kept = os.dup(2)
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)


class Judge:
    def __init__(self, folder: Path):
        self.folder = folder
        self.complaints = []

    def check(self, fair: bool, complaint: str):
        if not fair:
            self.complaints.append(f"{self.folder}: {complaint}")

    def exiftool(self, path: Path):
        """No warnings; the tags by name."""
        report = subprocess.run(
            ["exiftool", "-validate", "-warning", "-error", "-a", str(path)], capture_output=True, text=True
        )
        # "Validate : OK", or how many warnings there are and then one a line.
        verdict, *warnings = report.stdout.strip().splitlines() or [report.stderr]
        warnings = [warning for warning in warnings if not any(tag in warning for tag in DNG_1_6_TAGS)]
        self.check(
            report.returncode == 0 and not warnings and (verdict.endswith(": OK") or "(all minor)" in verdict),
            f"exiftool on {path.name}: {'; '.join([verdict, *warnings])}",
        )
        tags = subprocess.run(["exiftool", "-json", "-n", "-a", "-G1", str(path)], capture_output=True, text=True)
        return json.loads(tags.stdout)[0]

    def mosaics(self):
        """The numbers of every file, by file name."""
        found = {"raw.tiff": tifffile.imread(self.folder / "raw.tiff")}
        if (self.folder / "raw.npy").exists():
            found["raw.npy"] = numpy.load(self.folder / "raw.npy")
        if (self.folder / "raw.pgm").exists():
            data = (self.folder / "raw.pgm").read_bytes()
            magic, size, maximum, pixels = data.split(b"\n", 3)
            width, height = map(int, size.split())
            self.check(magic in (b"P5", b"P6") and maximum == b"65535", f"raw.pgm starts with {data[:32]!r}")
            shape = (height, width) if magic == b"P5" else (height, width, 3)
            found["raw.pgm"] = numpy.frombuffer(pixels, ">u2").reshape(shape)
        return found

    def judge(self):
        path = self.folder / "raw.dng"
        tags = self.exiftool(path)
        self.exiftool(self.folder / "raw.tiff")
        found = self.mosaics()
        numbers = found["raw.tiff"]
        linear = self.linear(numbers)
        is_float = tags["SubIFD:Compression"] == DEFLATE
        with tifffile.TiffFile(path) as file:
            found["raw.dng by tifffile"] = file.pages[0].pages[0].asarray()
        # It refuses what breaks the specification.
        with silence():
            found["raw.dng by Adobe's SDK"] = numpy.squeeze(dngpy.Dng(str(path)).raw_pixels)
        with rawpy.imread(str(path)) as raw:
            read = raw.raw_image.copy()
            if read.ndim == 3:
                read = read[:, :, : numbers.shape[2]]
            if is_float:
                self.scaled(read, linear)
            else:
                self.check(numpy.array_equal(read, linear), "LibRaw finds other linear numbers than the table makes")
                self.levels(raw, tags)
            self.colour(raw, tags)
        tile = tags.get("SubIFD:CFARepeatPatternDim", "2 2")
        # Of images with several values per pixel, dcraw takes the corner instead of the active area.
        moved = numbers.ndim == 3 and self.active(tags)[:2] != [0, 0]
        if not is_float and not moved and tile in ("2 2", "6 6"):
            self.dcraw(path, tags, linear)
        if (self.folder / "capture.json").exists():
            self.capture(tags)
        for name, pixels in found.items():
            self.check(pixels.shape == numbers.shape, f"{name} is {pixels.shape}, raw.tiff {numbers.shape}")
            if pixels.shape == numbers.shape:
                different = numpy.count_nonzero(pixels != numbers)
                self.check(different == 0, f"{name} differs from raw.tiff in {different} numbers")
        return self.complaints

    def scaled(self, read, numbers):
        """LibRaw brings floating-point numbers to a largest of 16383 unless that lies in 4096-32767."""
        largest = int(numbers.max())
        # It cuts off what is behind the point, and takes its largest from the white level where that is higher.
        factor = 1.0 if 4096 <= largest <= 32767 else read.max() / largest
        difference = numpy.abs(read - numbers * factor).max()
        self.check(difference <= 2.0, f"LibRaw's numbers differ by up to {difference} from {factor} times ours")

    @staticmethod
    def active(tags):
        return [int(n) for n in tags["SubIFD:ActiveArea"].split()]

    def linear(self, numbers):
        """What programs that know LinearizationTable must make of the numbers."""
        path = self.folder / "capture.json"
        table = json.loads(path.read_text())["sensor"].get("linearisation_dn") if path.exists() else None
        return numbers if table is None else numpy.array(table, "uint16")[numbers]

    def dcraw(self, path, tags, numbers):
        run = subprocess.run(["dcraw", "-D", "-4", "-t", "0", "-c", str(path)], capture_output=True)
        self.check(run.returncode == 0, f"dcraw: {run.stderr.decode()}")
        if run.returncode != 0:
            return
        magic, size, _, pixels = run.stdout.split(b"\n", 3)
        width, height = map(int, size.split())
        shape = (height, width) if magic == b"P5" else (height, width, 3)
        read = numpy.frombuffer(pixels, ">u2").reshape(shape)
        top, left, bottom, right = self.active(tags)
        expected = numbers[top:bottom, left:right]
        self.check(
            read.shape == expected.shape and numpy.array_equal(read, expected),
            f"dcraw finds other numbers: {read.shape} for {expected.shape}",
        )

    def developers(self):
        path = self.folder / "raw.dng"
        tags = self.exiftool(path)
        top, left, bottom, right = self.active(tags)
        with tempfile.TemporaryDirectory() as scratch:
            rawtherapee = Path(scratch) / "rawtherapee.tif"
            darktable = Path(scratch) / "darktable.tif"
            for name, command, picture, frame in [
                ("RawTherapee", ["rawtherapee-cli", "-q", "-Y", "-o", rawtherapee, "-d", "-b16", "-t", "-c", path], rawtherapee, RAWTHERAPEE_FRAME),
                (
                    "darktable",
                    ["darktable-cli", path, darktable, "--core", "--library", ":memory:", "--configdir", scratch],
                    darktable,
                    0,
                ),
            ]:
                run = subprocess.run([str(part) for part in command], capture_output=True, text=True)
                if not picture.exists():
                    self.check(False, f"{name} develops nothing: {run.stdout[-300:]} {run.stderr[-300:]}")
                    continue
                read = tifffile.imread(picture)
                missing = [bottom - top - read.shape[0], right - left - read.shape[1]]
                self.check(
                    all(0 <= lines <= 2 * frame for lines in missing),
                    f"{name}'s image is {read.shape[:2]}, not {(bottom - top, right - left)}",
                )
                self.check(read.std() > 0, f"{name}'s image is of one colour")
        return self.complaints

    def capture(self, tags):
        capture = json.loads((self.folder / "capture.json").read_text())
        sensor = capture["sensor"]
        for tag, expected in {
            "ExifIFD:ExposureTime": capture["exposure"]["time_s"],
            "ExifIFD:ISO": min(round(capture["exposure"]["iso"]), 65535) if capture["exposure"]["iso"] else None,
            "ExifIFD:FNumber": capture["lens"]["f_number"],
            "ExifIFD:FocalLength": capture["lens"]["focal_length_mm"],
            "SubIFD:BlackLevel": sensor["black_level_dn"],
            "SubIFD:WhiteLevel": sensor["white_level_dn"],
            "SubIFD:ImageWidth": sensor["resolution_px"][0],
            "SubIFD:ImageHeight": sensor["resolution_px"][1],
        }.items():
            if expected is None:
                self.check(tag not in tags, f"{tag} is {tags.get(tag)}, where there is none")
                continue
            for value in str(tags[tag]).split():
                self.check(math.isclose(float(value), expected, rel_tol=1e-6), f"{tag} is {value}, not {expected}")

    def levels(self, raw, tags):
        black = [float(level) for level in str(tags["SubIFD:BlackLevel"]).split()]
        white = int(str(tags["SubIFD:WhiteLevel"]).split()[0])
        read = raw.black_level_per_channel
        if len(set(black)) == 1:
            self.check(set(read[: raw.num_colors]) == {black[0]}, f"LibRaw's black level {read}, not {black[0]}")
        elif raw.raw_type == rawpy.RawType.Flat and len(black) == 4 and raw.color_desc == b"RGBG":
            pattern = raw.raw_colors_visible[:2, :2].flatten()
            found = [read[colour] for colour in pattern]
            letters = str(tags["SubIFD:CFAPattern2"]).split()
            # LibRaw cannot tell two pixels of one colour apart unless that is green.
            self.check(found == black or letters.count("1") != 2, f"LibRaw's black levels {found}, not {black}")
        self.check(raw.white_level == white, f"LibRaw's white level {raw.white_level}, not {white}")

    def colour(self, raw, tags):
        pattern = tags.get("SubIFD:CFAPattern2")
        if pattern is None:
            samples = int(tags["SubIFD:SamplesPerPixel"])
            self.check(raw.num_colors == samples, f"LibRaw sees {raw.num_colors} colours in an image of {samples}")
            if samples == 1:
                return
        else:
            rows, columns = (int(n) for n in tags["SubIFD:CFARepeatPatternDim"].split())
            if (rows, columns) not in ((2, 2), (6, 6)):
                return
            written = numpy.array([int(code) for code in str(pattern).split()]).reshape(rows, columns)
            if rows == 6 and self.active(tags)[:2] != [0, 0]:
                # rawpy then reads beside LibRaw's table.
                return
            read = raw.raw_colors_visible[:rows, :columns]
            description = raw.color_desc.decode()
            if set(written.flatten()) == {0, 1, 2}:
                letters = [[CFA_LETTERS[code] for code in row] for row in written]
                found = [[description[colour] for colour in row] for row in read]
                self.check(found == letters, f"LibRaw's mosaic {found}, not {letters}")
            else:
                # LibRaw has names for few colours; the same number must mean the same filter. It numbers a second
                # pixel of one colour apart from the first.
                pairs = set(zip(read.flatten().tolist(), written.flatten().tolist()))
                self.check(len(pairs) == len({colour for colour, _ in pairs}), f"LibRaw's mosaic {read.tolist()}")
                return
        second = 2 if tags.get("IFD0:CalibrationIlluminant2") == D65 else 1
        # LibRaw does not give the matrix itself but what follows from it: camera -> sRGB for balanced channels, that is
        # the inverse of the matrix for D65 times (sRGB -> XYZ) with every row's sum brought to 1.
        matrix = numpy.array([float(x) for x in tags[f"IFD0:ColorMatrix{second}"].split()]).reshape(3, 3)
        from_srgb = matrix @ SRGB_TO_XYZ
        to_srgb = numpy.linalg.inv(from_srgb / from_srgb.sum(axis=1, keepdims=True))
        # Its sRGB matrix has seven digits, and the inverse of a camera matrix multiplies an error by less than 10.
        self.check(
            numpy.allclose(raw.color_matrix[:, :3], to_srgb, rtol=0, atol=1e-5),
            f"LibRaw's colour matrix {raw.color_matrix[:, :3].tolist()}, not {to_srgb.tolist()}",
        )
        neutral = numpy.array([float(x) for x in tags["IFD0:AsShotNeutral"].split()])
        balance = numpy.array(raw.camera_whitebalance[:3]) * neutral
        # LibRaw corrects the balance for black levels that differ between the channels of full images.
        uneven = pattern is None and len(set(str(tags["SubIFD:BlackLevel"]).split())) > 1
        self.check(
            uneven or numpy.allclose(balance, balance[1], rtol=1e-5),
            f"LibRaw's white balance {raw.camera_whitebalance} does not undo the neutral {neutral.tolist()}",
        )


def main():
    arguments = sys.argv[1:]
    develop = "--developers" in arguments
    folders = [Path(argument) for argument in arguments if argument != "--developers"]
    if not folders:
        sys.exit(__doc__)
    complaints = []
    for folder in folders:
        judge = Judge(folder)
        complaints += judge.developers() if develop else judge.judge()
    for complaint in complaints:
        print(complaint, file=sys.stderr)
    print(f"{len(folders)} raw images judged, {len(complaints)} complaints")
    sys.exit(1 if complaints else 0)


if __name__ == "__main__":
    main()
