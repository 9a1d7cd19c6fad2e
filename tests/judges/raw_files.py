#!/usr/bin/env python3
"""Reads photosite's raw files back with programs that nobody here wrote.

    raw_files.py FOLDER...

Each FOLDER holds raw.dng and raw.tiff, and may hold raw.pgm and raw.npy of the same mosaic. LibRaw (through rawpy) must
find the very same digital numbers in the DNG as tifffile does in the TIFF, and the same black level, white level,
colour filter array and colour matrix as exiftool finds in the tags; exiftool must find nothing to warn about. Where the
folder holds a capture.json too, the tags must say the exposure, lens and levels that it says.
Exit status 0 where all is well, 1 otherwise.

Needs: pip install -r requirements.txt, apt-get install libimage-exiftool-perl.
"""

import json
import math
import subprocess
import sys
from pathlib import Path

import numpy
import rawpy
import tifffile

CFA_LETTERS = "RGB"

# IEC 61966-2-1, as LibRaw has it.
SRGB_TO_XYZ = numpy.array([[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]])


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
        verdict = report.stdout.strip()
        self.check(
            report.returncode == 0 and verdict.count("\n") == 0 and verdict.endswith(": OK"),
            f"exiftool on {path.name}: {verdict or report.stderr}",
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
            self.check(magic == b"P5" and maximum == b"65535", f"raw.pgm starts with {data[:32]!r}")
            found["raw.pgm"] = numpy.frombuffer(pixels, ">u2").reshape(height, width)
        return found

    def judge(self):
        tags = self.exiftool(self.folder / "raw.dng")
        self.exiftool(self.folder / "raw.tiff")
        mosaics = self.mosaics()
        numbers = mosaics["raw.tiff"]
        with rawpy.imread(str(self.folder / "raw.dng")) as raw:
            mosaics["raw.dng"] = raw.raw_image_visible.copy()
            self.levels(raw, tags)
            self.colour(raw, tags, numbers)
        if (self.folder / "capture.json").exists():
            self.capture(tags)
        for name, mosaic in mosaics.items():
            self.check(mosaic.dtype.newbyteorder("=") == numpy.uint16, f"{name} holds {mosaic.dtype}")
            self.check(mosaic.shape == numbers.shape, f"{name} is {mosaic.shape}, raw.tiff {numbers.shape}")
            if mosaic.shape == numbers.shape:
                different = numpy.count_nonzero(mosaic != numbers)
                self.check(different == 0, f"{name} differs from raw.tiff in {different} pixels")
        return self.complaints

    def capture(self, tags):
        capture = json.loads((self.folder / "capture.json").read_text())
        sensor = capture["sensor"]
        for tag, expected in {
            "ExifIFD:ExposureTime": capture["exposure"]["time_s"],
            "ExifIFD:FNumber": capture["lens"]["f_number"],
            "ExifIFD:FocalLength": capture["lens"]["focal_length_mm"],
            "SubIFD:BlackLevel": sensor["black_level_dn"],
            "SubIFD:WhiteLevel": sensor["white_level_dn"],
            "SubIFD:ImageWidth": sensor["resolution_px"][0],
            "SubIFD:ImageHeight": sensor["resolution_px"][1],
        }.items():
            self.check(math.isclose(tags[tag], expected, rel_tol=1e-6), f"{tag} is {tags[tag]}, not {expected}")

    def levels(self, raw, tags):
        black, white = tags["SubIFD:BlackLevel"], tags["SubIFD:WhiteLevel"]
        self.check(
            set(raw.black_level_per_channel) == {black}, f"LibRaw's black level {raw.black_level_per_channel}, not {black}"
        )
        self.check(raw.white_level == white, f"LibRaw's white level {raw.white_level}, not {white}")

    def colour(self, raw, tags, numbers):
        pattern = tags.get("SubIFD:CFAPattern2")
        if pattern is None:
            self.check(raw.num_colors == 1, f"LibRaw sees {raw.num_colors} colours in a monochrome picture")
            return
        written = "".join(CFA_LETTERS[int(i)] for i in str(pattern).split())
        description = raw.color_desc.decode()
        read = "".join(description[i] for i in raw.raw_pattern.flatten())
        self.check(read == written, f"LibRaw's mosaic {read}, not {written}")
        visible = "".join(description[raw.raw_color(y, x)] for y in (0, 1) for x in (0, 1))
        self.check(visible == written, f"LibRaw's top-left pixels {visible}, not {written}")
        # LibRaw does not give the matrix itself but what follows from it: camera -> sRGB for balanced channels, that is
        # the inverse of ColorMatrix1 times (sRGB -> XYZ) with every row's sum brought to 1.
        matrix = numpy.array([float(x) for x in tags["IFD0:ColorMatrix1"].split()]).reshape(3, 3)
        from_srgb = matrix @ SRGB_TO_XYZ
        to_srgb = numpy.linalg.inv(from_srgb / from_srgb.sum(axis=1, keepdims=True))
        # Its sRGB matrix has seven digits, and the inverse of a camera matrix multiplies an error by less than 10.
        self.check(
            numpy.allclose(raw.color_matrix[:, :3], to_srgb, rtol=0, atol=1e-5),
            f"LibRaw's colour matrix {raw.color_matrix[:, :3].tolist()}, not {to_srgb.tolist()}",
        )
        neutral = numpy.array([float(x) for x in tags["IFD0:AsShotNeutral"].split()])
        balance = numpy.array(raw.camera_whitebalance[:3]) * neutral
        self.check(
            numpy.allclose(balance, balance[1], rtol=1e-5),
            f"LibRaw's white balance {raw.camera_whitebalance} does not undo the neutral {neutral.tolist()}",
        )


def main():
    folders = [Path(argument) for argument in sys.argv[1:]]
    if not folders:
        sys.exit(__doc__)
    complaints = [complaint for folder in folders for complaint in Judge(folder).judge()]
    for complaint in complaints:
        print(complaint, file=sys.stderr)
    print(f"{len(folders)} raw pictures judged, {len(complaints)} complaints")
    sys.exit(1 if complaints else 0)


if __name__ == "__main__":
    main()
