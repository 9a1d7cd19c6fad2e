"""Tone curves for light of high dynamic range, against their published equations and OpenCV."""

import cv2
import numpy
from pictures import develop, largest, write_exr
from rows.colour import to_xyz
from table import Figure, Row


def light(tool, colours=False):
    """Five decades of luminance on 48 × 36 pixels, and the file that holds them."""
    y, x = numpy.mgrid[0:36, 0:48]
    grey = 10 ** (x / 12 - 2 + 0.3 * numpy.sin(y / 2) * (x % 7) / 7 + 0.8 * (y > 18))
    picture = grey[..., None] * ([1.2, 0.9, 0.6] if colours else [1, 1, 1])
    return picture.astype("f4").astype(float), write_exr(tool.scratch / "light.exr", picture)


def logarithmic_mean(luminance):
    return numpy.exp(numpy.log(luminance).mean())


def bracket(tool):
    """The lamp, which saturates the longest exposure, over the wall behind, which is dark in the shortest."""
    larger = ["sensor.resolution_px=[200, 200]", "sensor.pixel_pitch_um=[12, 12]", "render.samples_per_pixel=64"]
    # What falloff the lens has stays, as it does in what an ideal observer sees.
    folder = tool.render("tone.toml", "tone", "output.ideal=true", "develop.lens_falloff=false", *larger)
    grey = ["colour_model=grey"]
    merged, seen = (develop(tool, folder / name, *grey).astype(float) for name in ["hdr.exr", "ideal.exr"])
    single = develop(tool, folder / "raw-0002.dng", *grey, "lens_falloff=false").astype(float)
    lamp = cv2.erode((seen > 0.9 * seen.max()).astype("u1"), numpy.ones((3, 3))) > 0
    wall = numpy.zeros_like(lamp)
    wall[75:110, 105:140] = True
    contrast = [float(picture[lamp].mean() / picture[wall].mean()) for picture in (merged, seen, single)]
    return [
        # The camera is no colorimeter: its matrix is right to a few percent.
        Figure("lamp over wall, merged", contrast[0], contrast[1], 0.05 * contrast[1], "the light itself"),
        Figure("lamp over wall in the longest exposure, in parts of that", contrast[2] / contrast[1], 0, 0.1),
    ]


def reinhard(tool):
    picture, path = light(tool, True)
    luminance = picture @ to_xyz(tool)[1]
    scaled = 0.18 / logarithmic_mean(luminance) * luminance
    figures = []
    for name, settings, white in [
        ("eq. 4, white at the brightest pixel", [], scaled.max()),
        ("eq. 4, L_white = 2", ["tone_white=2"], 2),
        ("eq. 3, L_white = ∞", ["tone_white=inf"], numpy.inf),
    ]:
        shown = scaled * (1 + scaled / white**2) / (1 + scaled)
        expected = picture * (shown / luminance)[..., None]
        found = develop(tool, path, "tone_curve=reinhard", *settings)
        figures.append(
            Figure(f"{name}, largest relative difference", float((numpy.abs(found / expected - 1)).max()), 0, 1e-6)
        )
    cv2.imwrite(str(tool.picture("tone.png")), comparison(tool))
    return figures


def comparison(tool):
    """A bracket of the Cornell box, merged, by four curves."""
    folder = tool.render("tone.toml", "tone")
    pictures = []
    for settings in [[], ["tone_curve=reinhard"], ["tone_curve=log"], ["tone_curve=local"]]:
        path = develop(tool, folder / "hdr.exr", *settings, output=f"{len(pictures)}.png")
        pictures.append(cv2.imread(str(path)))
    return numpy.hstack(pictures)


def drago(tool):
    picture, path = light(tool)
    luminance = picture[..., 0]
    scaled = luminance / logarithmic_mean(luminance)
    most = scaled.max()
    base = 2 + 8 * (scaled / most) ** (numpy.log(0.85) / numpy.log(0.5))
    expected = numpy.log10(scaled + 1) / numpy.log10(most + 1) * numpy.log(10) / numpy.log(base)
    found = develop(tool, path, "tone_curve=log")[..., 0]
    # OpenCV moves the light to 0–1, and cuts it off at 1e-4 of that, we at 1e-6: a black pixel and a largest one of 0.01
    # leave it as it is. Of black it makes no number, and of the rest its scale is another.
    narrow = 0.01 * (luminance / luminance.max()) ** 0.6
    narrow[0, 0] = 0
    narrow = numpy.repeat(narrow[..., None], 3, 2).astype("f4")
    theirs = cv2.createTonemapDrago(gamma=1, saturation=1, bias=0.85).process(narrow)[..., 0]
    ours = develop(tool, write_exr(tool.scratch / "narrow.exr", narrow), "tone_curve=log")[..., 0]
    apart = numpy.nanmax(numpy.abs(ours - theirs / theirs[narrow[..., 0] == narrow.max()]))
    return [
        Figure("eq. 4, largest difference", largest(found, expected), 0, 1e-6),
        Figure("createTonemapDrago, largest difference", float(apart), 0, 1e-5, "OpenCV"),
    ]


def filmic(tool):
    picture, path = light(tool)
    expected = picture * (2.51 * picture + 0.03) / (picture * (2.43 * picture + 0.59) + 0.14)
    return [Figure("largest difference", largest(develop(tool, path, "tone_curve=filmic"), expected), 0, 1e-6)]


def local(tool):
    picture, path = light(tool)
    logarithm = numpy.log10(numpy.maximum(picture[..., 0], 1e-5 * picture.max())).astype("f4")
    sigma = 3
    base = cv2.bilateralFilter(logarithm, 6 * sigma + 1, 0.4, sigma, borderType=cv2.BORDER_REFLECT_101)
    compression = min(1, numpy.log10(50) / (base.max() - base.min()))
    expected = compression * (base - base.max()) + logarithm - base
    found = numpy.log10(develop(tool, path, "tone_curve=local", f"tone_sigma_px={sigma}")[..., 0])
    # Straight lines between levels σ_r/4 apart miss the base by σ_r/128 or 0.003, and OpenCV's window is a disk.
    return [Figure("log₁₀ of what is shown, largest difference", largest(found, expected), 0, 0.008, "OpenCV")]


ROWS = [
    Row("Exposure bracket", "L = Σ (tᵢ·xᵢ/vᵢ)/Σ (tᵢ²/vᵢ)", "tone.toml", bracket),
    Row(
        "Reinhard's global curve", "L_d = L·(1 + L/L_white²)/(1 + L), L = a·L_w/L̄_w", "tone.toml", reinhard, "tone.png"
    ),
    Row(
        "Logarithmic curve (Drago)",
        "L_d = log₁₀(L + 1)/log₁₀(L_max + 1) · ln 10/ln(2 + 8·(L/L_max)^(ln b/ln ½))",
        "photosite develop hdr.exr -o image.png --set develop.tone_curve=log",
        drago,
    ),
    Row(
        "Filmic curve",
        "x·(2.51x + 0.03)/(x·(2.43x + 0.59) + 0.14)",
        "photosite develop hdr.exr -o image.png --set develop.tone_curve=filmic",
        filmic,
    ),
    Row(
        "Local curve by a bilateral base",
        "log L_d = γ·(B − max B) + (log L − B)",
        "photosite develop hdr.exr -o image.png --set develop.tone_curve=local",
        local,
    ),
]
