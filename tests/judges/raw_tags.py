#!/usr/bin/env python3
"""Develops DNG files that say one thing each, and compares the images with those of LibRaw and of NumPy.

    raw_tags.py BINARY

Each file has one tag or opcode more than the others. photosite must find the digital numbers that tifffile finds, and
develop them to the linear light that DNG 1.7 asks for: chapters 4 and 5 for tags, chapter 7 for opcodes, computed here with
NumPy. What LibRaw (through rawpy) knows, it must find alike: stored numbers, levels, filters, turned and cropped sizes.
Exit status 0 where all is well, 1 otherwise.

Needs: pip install -r requirements.txt.
"""

import json
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

import imagecodecs
import numpy
import rawpy
import tifffile

HEIGHT, WIDTH = 40, 56
WHITE = 4000
BYTE, SHORT, LONG, RATIONAL, UNDEFINED, SRATIONAL = 1, 3, 4, 5, 7, 10
# LibRaw's rawpy.ffi: sizes.flip of EXIF's orientations 1 to 8.
LIBRAW_FLIPS = {1: 0, 3: 3, 6: 6, 8: 5}
RGGB = (0, 1, 1, 2)


def fraction(value):
    return [int(round(value * 10000)), 10000]


def mosaic(maximum=WHITE):
    """Smooth numbers of all three colours, none of them saturated, another one in each pixel."""
    y, x = numpy.mgrid[0:HEIGHT, 0:WIDTH]
    return ((0.2 + 0.45 * x / WIDTH + 0.2 * y / HEIGHT) * maximum * (1 - 0.2 * (x % 2) + 0.1 * (y % 2))).astype("uint16")


def tags_of(cfa=RGGB, **more):
    """The tags of a mosaic that sees as linear sRGB does; None leaves one out."""
    tags = {
        50706: (BYTE, [1, 7, 1, 0]),
        50707: (BYTE, [1, 4, 0, 0]),
        33421: (SHORT, [2, 2]),
        33422: (BYTE, list(cfa)),
        50717: (LONG, [WHITE]),
        50721: (SRATIONAL, sum((fraction(x) for x in (3.2404542, -1.5371385, -0.4985314, -0.969266, 1.8760108, 0.041556, 0.0556434, -0.2040259, 1.0572252)), [])),
        50728: (RATIONAL, fraction(1) * 3),
        50778: (SHORT, [21]),
    }
    for number, value in more.pop("tags", {}).items():
        tags[number] = value
    return {number: value for number, value in tags.items() if value is not None}


def write(path, numbers, tags, bits=16, compression=None):
    """As tifffile writes TIFF; packed where the bits are fewer than 16, most significant first."""
    extra = []
    for number, (kind, values) in sorted(tags.items()):
        if kind == UNDEFINED:
            extra.append((number, kind, len(values), bytes(values), True))
            continue
        count = len(values) // 2 if kind in (RATIONAL, SRATIONAL) else len(values)
        extra.append((number, kind, count, tuple(values) if len(values) > 1 else values[0], True))
    photometric = 34892 if 33422 not in tags else 32803
    data = numbers.astype("uint8") if bits == 8 else numbers
    options = {"bitspersample": bits} if bits not in (8, 16) else {}
    if compression == "jpeg":
        # Lossless, in one strip that is coded already.
        options = {"shape": data.shape, "dtype": data.dtype}
        data = iter([imagecodecs.ljpeg_encode(data)])
    tifffile.imwrite(
        path, data, photometric=photometric, planarconfig="contig" if numbers.ndim == 3 else None, extratags=extra,
        compression=compression, metadata=None, software=None, rowsperstrip=HEIGHT, **options,
    )


def opcode(identifier, body):
    return struct.pack(">IIII", identifier, 0x01030000, 0, len(body)) + body


def opcodes(*of):
    return UNDEFINED, list(struct.pack(">I", len(of)) + b"".join(of))


def area(top, left, bottom, right, planes=1, pitch=1):
    return struct.pack(">8I", top, left, bottom, right, 0, planes, pitch, pitch)


class Judge:
    def __init__(self, binary, scratch):
        self.binary, self.scratch, self.complaints, self.cases = binary, Path(scratch), [], 0

    def check(self, fair, complaint):
        if not fair:
            self.complaints.append(complaint)

    def develop(self, name, *settings):
        """The developed planes, or None; the steps that would mix pixels are left out."""
        to = self.scratch / f"{name}.npy"
        keys = ("demosaic=nearest", "tone_curve=linear", "colour_matrix=false", "square_pixels=false", *settings)
        command = [self.binary, "develop", self.scratch / f"{name}.dng", "-o", to, "--force", "--json"]
        run = subprocess.run([*command, *(f"--set=develop.{key}" for key in keys)], capture_output=True, text=True)
        self.check(run.returncode == 0, f"{name}: {run.stderr.strip()}")
        return (numpy.load(to).astype("float64"), json.loads(run.stdout)) if run.returncode == 0 else None

    def case(self, name, numbers, tags, expected, settings=(), libraw=None, warnings=0, tolerance=2e-6, **form):
        """A file, what NumPy expects of its signal pixel by pixel, and what LibRaw must find."""
        self.cases += 1
        path = self.scratch / f"{name}.dng"
        write(path, numbers, tags, **form)
        developed = self.develop(name, *settings)
        if developed is None:
            return
        image, report = developed
        self.check(len(report["warnings"]) == warnings, f"{name}: warnings {report['warnings']}")
        # Each pixel's own colour is what the nearest neighbour leaves of a mosaic.
        if image.ndim == 3 and expected.ndim == 2:
            self.check(image.shape[:2] == expected.shape, f"{name}: {image.shape[:2]}, not {expected.shape}")
            if image.shape[:2] != expected.shape:
                return
            distance = numpy.abs(image - expected[:, :, None]).min(axis=2).max()
        else:
            self.check(image.shape == expected.shape, f"{name}: {image.shape}, not {expected.shape}")
            if image.shape != expected.shape:
                return
            distance = numpy.abs(image - expected).max()
        self.check(distance < tolerance, f"{name}: differs by {distance} from what DNG asks for")
        if libraw is not None:
            with rawpy.imread(str(path)) as raw:
                libraw(raw)

    def numbers(self, name, numbers):
        return lambda raw: self.check(numpy.array_equal(raw.raw_image, numbers), f"{name}: LibRaw finds other numbers")

    def levels(self, name, black, white):
        def judge(raw):
            found = [raw.black_level_per_channel[c] for c in raw.raw_colors_visible[:2, :2].flatten()]
            self.check(numpy.allclose(found, black), f"{name}: LibRaw's black levels {found}, not {black}")
            self.check(raw.white_level == white, f"{name}: LibRaw's white level {raw.white_level}, not {white}")

        return judge

    def tags(self):
        numbers = mosaic()
        signal = numbers / WHITE
        for turn in range(1, 9):
            turned = [
                lambda a: a, numpy.fliplr, lambda a: numpy.rot90(a, 2), numpy.flipud, numpy.transpose,
                lambda a: numpy.rot90(a, -1), lambda a: numpy.rot90(a, 2).T, numpy.rot90,
            ][turn - 1]
            name = f"orientation-{turn}"

            def sizes(raw, turn=turn, name=name):
                if turn in LIBRAW_FLIPS:
                    self.check(raw.sizes.flip == LIBRAW_FLIPS[turn], f"{name}: LibRaw's flip {raw.sizes.flip}")

            self.case(name, numbers, tags_of(tags={274: (SHORT, [turn])}), turned(signal), libraw=sizes)
        for black in ([64], [10, 20, 30, 40]):
            repeat = [1, 1] if len(black) == 1 else [2, 2]
            tile = numpy.tile(numpy.array(black).reshape(repeat), (HEIGHT // repeat[0], WIDTH // repeat[1]))
            name = f"black-{len(black)}"
            tags = tags_of(tags={50713: (SHORT, repeat), 50714: (SHORT, black)})
            self.case(name, numbers, tags, (numbers - tile) / (WHITE - tile), libraw=self.levels(name, (black * 4)[:4], WHITE))
        across = numpy.arange(WIDTH) % 5 - 2
        down = numpy.arange(HEIGHT) % 7 - 3
        deltas = 100 + across[None, :] + down[:, None]
        tags = tags_of(
            tags={
                50714: (SHORT, [100]),
                50715: (SRATIONAL, sum((fraction(d) for d in across), [])),
                50716: (SRATIONAL, sum((fraction(d) for d in down), [])),
            }
        )
        self.case("black-deltas", numbers, tags, (numbers - deltas) / (WHITE - deltas))
        table = (numpy.arange(4096, dtype="float64") ** 2 / 4095).astype("uint16")
        linear = table[numbers]
        self.case(
            "linearisation", numbers, tags_of(tags={50712: (SHORT, table.tolist())}), linear / WHITE,
            libraw=self.numbers("linearisation", linear),
        )
        # LibRaw brings an odd corner to an even one.
        for name, top, left in (("active-area", 4, 6), ("active-area-odd", 3, 5)):
            active = numpy.s_[top : top + 32, left : left + 44]

            def visible(raw, name=name, active=active):
                self.check(numpy.array_equal(raw.raw_image_visible, numbers[active]), f"{name}: LibRaw sees another part")

            tags = tags_of(tags={50829: (LONG, [top, left, top + 32, left + 44])})
            self.case(name, numbers, tags, signal[active], libraw=visible if top == 4 else None)
        crop = {50719: (LONG, [4, 2]), 50720: (LONG, [20, 14])}
        self.case("default-crop", numbers, tags_of(tags=crop), signal[2:16, 4:24], warnings=1)
        self.case("default-crop-off", numbers, tags_of(tags=crop), signal, settings=["default_crop=false"])
        both = {**crop, 50829: (LONG, [3, 5, 35, 49])}
        self.case("crop-of-active-area", numbers, tags_of(tags=both), signal[5:19, 9:29], warnings=1)
        rotated = {**crop, 274: (SHORT, [6])}
        self.case("crop-turned", numbers, tags_of(tags=rotated), numpy.rot90(signal[2:16, 4:24], -1), warnings=1)
        self.case("baseline-exposure", numbers, tags_of(tags={50730: (SRATIONAL, [1, 2])}), signal * 2**0.5)
        neutral = [0.5, 1.0, 0.625]
        tags = tags_of(tags={50728: (RATIONAL, sum((fraction(n) for n in neutral), [])), 50717: (LONG, [8000])})
        of = numpy.tile(numpy.array(neutral)[[0, 1, 1, 2]].reshape(2, 2), (HEIGHT // 2, WIDTH // 2))

        def balance(raw):
            found = numpy.array(raw.camera_whitebalance[:3]) * neutral
            self.check(numpy.allclose(found, found[1], rtol=1e-4), f"neutral: LibRaw's balance {raw.camera_whitebalance}")

        self.case("neutral", numbers, tags, numpy.minimum(numbers / 8000 / of, 1), libraw=balance)
        for pattern in ((0, 1, 1, 2), (2, 1, 1, 0), (1, 0, 2, 1), (1, 2, 0, 1)):
            name = "cfa-" + "".join("RGB"[c] for c in pattern)

            def filters(raw, name=name, pattern=pattern):
                letters = raw.color_desc.decode()
                found = [letters[c] for c in raw.raw_colors_visible[:2, :2].flatten()]
                self.check(found == ["RGB"[c] for c in pattern], f"{name}: LibRaw's mosaic {found}")

            self.case(name, numbers, tags_of(pattern), signal, libraw=filters)
            # A colour is where its filter is.
            image, _ = self.develop(name)
            for i, colour in enumerate(pattern):
                part = numpy.s_[i // 2 :: 2, i % 2 :: 2]
                self.check(numpy.allclose(image[part][:, :, colour], signal[part], atol=2e-6), f"{name}: {i} is not {colour}")
        planes = numpy.stack([mosaic(), mosaic(3000), mosaic(2000)], axis=2)
        tags = tags_of(tags={33421: None, 33422: None, 50717: (LONG, [4000, 3500, 3000])})
        self.case("white-levels", planes, tags, planes / numpy.array([4000, 3500, 3000]))

    def storage(self):
        for bits in (8, 12, 14, 16):
            white = 2**bits - 1
            numbers = mosaic(white)
            name = f"bits-{bits}"
            tags = tags_of(tags={50717: None})
            self.case(name, numbers, tags, numbers / white, libraw=self.numbers(name, numbers), bits=bits)
        for compression in ("adobe_deflate", "jpeg"):
            numbers = mosaic()
            if compression == "adobe_deflate":
                # Whole numbers under deflate are floating-point ones in DNG.
                write_numbers, libraw = numbers.astype("float32"), None
            else:
                write_numbers, libraw = numbers, self.numbers("jpeg", numbers)
            self.case(compression, write_numbers, tags_of(), numbers / WHITE, libraw=libraw, compression=compression)

    def opcodes(self):
        numbers = mosaic()
        signal = numbers / WHITE
        y, x = numpy.mgrid[0:HEIGHT, 0:WIDTH]
        centre = (0.45, 0.6)
        dx, dy = x - centre[0] * (WIDTH - 1), y - centre[1] * (HEIGHT - 1)
        corners = [(cx - centre[0] * (WIDTH - 1)) ** 2 + (cy - centre[1] * (HEIGHT - 1)) ** 2 for cx in (0, WIDTH - 1) for cy in (0, HEIGHT - 1)]
        r2 = (dx**2 + dy**2) / max(corners)
        k = (0.1, 0.05, -0.02, 0.03, 0.01)
        vignette = opcode(3, struct.pack(">7d", *k, *centre))
        gain = 1 + sum(k[i] * r2 ** (i + 1) for i in range(5))
        whole = area(0, 0, HEIGHT, WIDTH)
        rows = (numpy.arange(HEIGHT) % 4 / 8 + 0.75).astype("float32")
        columns = (numpy.arange(WIDTH) % 3 / 4 + 0.5).astype("float32")
        curve = (numpy.sqrt(numpy.arange(65536) / 65535) * 65535).round().astype(">u2")
        steps = numpy.arange(HEIGHT, dtype="float32") - 7
        low = (numpy.arange(8, 24) + 1000).reshape(4, 4)
        operations = {
            "vignette": (vignette, lambda s, white: s * gain),
            "scale-rows": (opcode(12, whole + struct.pack(f">I{HEIGHT}f", HEIGHT, *rows)), lambda s, white: s * rows[:, None]),
            "scale-columns": (opcode(13, whole + struct.pack(f">I{WIDTH}f", WIDTH, *columns)), lambda s, white: s * columns[None, :]),
            "delta-rows": (opcode(10, whole + struct.pack(f">I{HEIGHT}f", HEIGHT, *steps)), lambda s, white: s + steps[:, None] * white / 65535),
            "table": (opcode(7, whole + struct.pack(">I", 65536) + curve.tobytes()), lambda s, white: curve[(s / white * 65535).round().astype(int)] * (white / 65535)),
            "polynomial": (
                # Of list 1, the coefficients are those of stored numbers.
                lambda white: opcode(8, whole + struct.pack(">I3d", 2, 0.01 * white, 0.6, 0.3 / white)),
                lambda s, white: 0.01 * white + 0.6 * s + 0.3 * s * s / white,
            ),
            "gain-map": (
                opcode(9, whole + struct.pack(">2I4dI4f", 2, 2, 1.0, 1.0, 0.0, 0.0, 1, 1.0, 0.75, 0.5, 0.25)),
                lambda s, white: s * (1 - 0.25 * (x + 0.5) / WIDTH - 0.5 * (y + 0.5) / HEIGHT),
            ),
        }
        for name, (written, change) in operations.items():
            for number, tag in ((1, 51008), (2, 51009)):
                white = 65535.0 if number == 1 else 1.0
                bytes_of = written(white) if callable(written) else written
                stored = numbers.astype("float64") if number == 1 else signal
                expected = change(stored, white)
                expected = numpy.floor(expected + 0.5) / WHITE if number == 1 else expected
                # A rounding at half a step may go either way.
                tolerance = 1.01 / WHITE if number == 1 else 3e-5
                self.case(f"{name}-{number}", numbers, tags_of(tags={tag: opcodes(bytes_of)}), numpy.minimum(expected, 1), tolerance=tolerance)
        # In their order: (s·g)² is not s²·g.
        square = opcode(8, whole + struct.pack(">I3d", 2, 0.0, 0.0, 1.0))
        half = opcode(12, whole + struct.pack(f">I{HEIGHT}f", HEIGHT, *[0.5] * HEIGHT))
        self.case("square-half", numbers, tags_of(tags={51009: opcodes(square, half)}), signal**2 / 2)
        self.case("half-square", numbers, tags_of(tags={51009: opcodes(half, square)}), (signal / 2) ** 2)
        # Bad pixels of a plane of constant numbers.
        bad = numpy.full((HEIGHT, WIDTH), 2000, "uint16")
        bad[5, 7] = bad[11:13, 20:22] = 0
        listed = opcode(5, struct.pack(">3I2I4I", 0, 1, 1, 5, 7, 11, 20, 13, 22))
        constant = opcode(4, struct.pack(">2I", 0, 0))
        for name, of in (("bad-list", listed), ("bad-constant", constant)):
            self.case(name, bad, tags_of(tags={51008: opcodes(of)}), numpy.full((HEIGHT, WIDTH), 0.5))
        self.case("trim-bounds", numbers, tags_of(tags={51022: opcodes(opcode(6, struct.pack(">4I", 0, 0, 8, 8)))}), signal, warnings=1)
        # Planes of the demosaicked image, where the pixel's own colour is known.
        self.case("vignette-3", numbers, tags_of(tags={51022: opcodes(vignette)}), numpy.minimum(signal * gain, 1))


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    with tempfile.TemporaryDirectory() as scratch:
        judge = Judge(Path(sys.argv[1]).absolute(), scratch)
        judge.tags()
        judge.storage()
        judge.opcodes()
    for complaint in judge.complaints:
        print(complaint, file=sys.stderr)
    print(f"{judge.cases} raw files of one tag each judged, {len(judge.complaints)} complaints")
    sys.exit(1 if judge.complaints else 0)


if __name__ == "__main__":
    main()
