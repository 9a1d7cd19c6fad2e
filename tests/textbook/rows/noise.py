"""Noise: what is added to an image, and what a sensor adds by itself.

Tolerances are 5 standard errors of the figure, derived beside each.
"""

import math

import colour
import numpy as np
from PIL import Image, ImageDraw
from scipy import stats
from table import Figure, Row

SIZE = (384, 512)
COUNT = SIZE[0] * SIZE[1]
#: The sensor without noise of its own, of 256 × 192 pixels, quantum efficiency 0.6, K = 2 DN/e⁻, black level 1000.
SENSOR_SIZE = (192, 256)
SENSOR_COUNT = SENSOR_SIZE[0] * SENSOR_SIZE[1]
GAIN, BLACK = 2.0, 1000.0
#: Moments m₄, m₆, m₈ of numbers of variance 1.
MOMENTS = {"gaussian": (3, 15, 105), "laplacian": (6, 90, 2520), "uniform": (9 / 5, 27 / 7, 9)}


def add(tool, picture, *changes, output="noisy.npy", seed=0, options=()):
    """An image with noise, read back."""
    source = tool.scratch / "source.npy"
    np.save(source, np.asarray(picture, np.float32))
    keys = [part for change in changes for part in ("--set", change)]
    tool.run("noise", "add", source, "-o", output, "--force", "--seed", seed, *keys, *options)
    return np.load(tool.scratch / output).astype(float)


def even(value):
    return np.full(SIZE, value)


def error_of_sigma(sigma, kurtosis, count=COUNT):
    """Five standard errors of a sample standard deviation."""
    return 5 * sigma * math.sqrt((kurtosis - 1) / count) / 2


def error_of_kurtosis(moments, count=COUNT):
    fourth, sixth, eighth = moments
    return 5 * math.sqrt((eighth - 4 * fourth * sixth + 4 * fourth**3 - fourth**2) / count)


def additive(kind):
    def measure(tool):
        found = add(tool, even(100), f"{kind}.sigma=4")
        moments = MOMENTS[kind]
        figures = [
            Figure("mean", found.mean(), 100, 5 * 4 / math.sqrt(COUNT), "NumPy"),
            Figure("standard deviation", found.std(ddof=1), 4, error_of_sigma(4, moments[0]), "NumPy"),
            Figure(
                "kurtosis", stats.kurtosis(found.ravel(), fisher=False), moments[0], error_of_kurtosis(moments), "SciPy"
            ),
        ]
        if kind == "uniform":
            # The largest of N numbers lies 2·√3·σ/N below the end on average.
            figures.append(Figure("largest deviation", abs(found - 100).max(), 4 * math.sqrt(3), 1e-2))
        return figures

    return measure


def multiplicative(tool):
    figures = []
    for value in (20, 200):
        found = add(tool, even(value), "gaussian.sigma=0.1", "gaussian.multiplicative=true")
        expected = 0.1 * value
        tolerance = error_of_sigma(expected, 3)
        figures.append(Figure(f"σ at f = {value}", found.std(ddof=1), expected, tolerance, "NumPy"))
    return figures


def salt_and_pepper(tool):
    found = add(tool, even(100), "salt_and_pepper.part=0.1", "salt_and_pepper.salt=0.3", "full_scale=255")
    share = lambda value: (found == value).mean()
    within = lambda part: 5 * math.sqrt(part * (1 - part) / COUNT)
    return [
        Figure("share of salt", share(255), 0.03, within(0.03), "binomial"),
        Figure("share of pepper", share(0), 0.07, within(0.07), "binomial"),
        Figure("share left", share(100), 0.9, within(0.9), "binomial"),
    ]


def speckle(tool):
    figures = []
    contrast = 0.5
    for value in (50, 200):
        found = add(tool, even(value), f"speckle.contrast={contrast}")
        # The kurtosis of a gamma distribution of the shape 1/C² is 3 + 6·C².
        tolerance = 5 * contrast**2 * math.sqrt((2 + 6 * contrast**2) / COUNT)
        figures.append(Figure(f"σ²/f² at f = {value}", found.var(ddof=1) / value**2, contrast**2, tolerance, "NumPy"))
    full = add(tool, even(1), "speckle.contrast=1").ravel()
    # 1 % of the samples of an exponential distribution lie beyond this distance.
    distance = stats.kstest(full, "expon").statistic
    figures.append(Figure("C = 1: distance from exponential", distance, 0, 1.63 / math.sqrt(COUNT), "SciPy"))
    return figures


def film_grain(tool):
    factor, exponent, length = 0.8, 0.4, 2.0
    keys = [f"film_grain.factor={factor}", f"film_grain.exponent={exponent}", f"film_grain.correlation_px={length}"]
    figures = []
    # Neighbours go together: Σρ² over all distances is π·ℓ².
    independent = COUNT / (math.pi * length**2)
    for value in (30, 200):
        found = add(tool, even(value), *keys)
        expected = factor**2 * value ** (2 * exponent)
        tolerance = 5 * expected * math.sqrt(2 / independent)
        figures.append(Figure(f"σ² at f = {value}", found.var(), expected, tolerance, "NumPy"))
    n = found - found.mean()
    for lag in (1, 2, 4):
        expected = math.exp(-(lag**2) / (2 * length**2))
        along = (n[:, :-lag] * n[:, lag:]).mean() / n.var()
        figures.append(Figure(f"correlation at {lag} px", along, expected, 5 / math.sqrt(independent), "NumPy"))
    return figures


def sigma_map(tool):
    rows, columns = np.indices(SIZE)
    sigma = 1 + 4 * columns / SIZE[1]
    np.save(tool.scratch / "sigma.npy", sigma.astype(np.float32))
    takes = [add(tool, even(100), "sigma_map.file=sigma.npy", seed=seed) for seed in range(16)]
    ratio = np.std(takes, axis=0, ddof=1) / sigma
    within = 5 * math.sqrt(2 / (15 * COUNT / 2))
    figures = [
        Figure(f"σ̂²/σ², {half} half", (ratio[:, part] ** 2).mean(), 1, within, "NumPy")
        for half, part in (("left", slice(None, SIZE[1] // 2)), ("right", slice(SIZE[1] // 2, None)))
    ]
    distance = stats.kstest(15 * ratio.ravel() ** 2, stats.chi2(15).cdf).statistic
    return [*figures, Figure("distance of 15·σ̂²/σ² from χ²", distance, 0, 1.63 / math.sqrt(COUNT), "SciPy")]


def codes(tool):
    """Rounding and clipping, against NumPy on the same noise in floating-point numbers."""
    picture = np.tile(np.linspace(0, 255, SIZE[1]).round(), (SIZE[0], 1))
    exact = add(tool, picture, "laplacian.sigma=20")
    Image.fromarray(picture.astype(np.uint8)).save(tool.scratch / "codes.png")
    done = tool.json("noise", "add", "codes.png", "-o", "out.png", "--set", "laplacian.sigma=20")
    # Halves away from 0.
    rounded = np.trunc(exact + np.copysign(0.5, exact))
    found = np.asarray(Image.open(tool.scratch / "out.png"))
    return [
        Figure("pixels that differ", np.count_nonzero(found != rounded.clip(0, 255)), 0, 0, "NumPy"),
        Figure("values clipped at black", done["clipped"]["low"], np.count_nonzero(rounded < 0), 0, "NumPy"),
        Figure("values clipped at white", done["clipped"]["high"], np.count_nonzero(rounded > 255), 0, "NumPy"),
    ]


def decoded(codes):
    """Linear light of sRGB codes."""
    v = codes / 255
    return np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)


def linear_light(tool):
    value = 128
    Image.new("L", SIZE[::-1], value).save(tool.scratch / "grey.png")
    figures = []
    for light in (False, True):
        options = ["--linear"] if light else []
        tool.run(
            "noise", "add", "grey.png", "-o", "out.png", "--force", *options,
            "--set", "levels=full-scale", "--set", "gaussian.sigma=0.04",
        )  # fmt: skip
        found = np.asarray(Image.open(tool.scratch / "out.png")).astype(float)
        # Rounding of codes adds q²/12; the slope of the curve near 128 turns it into light.
        if light:
            slope = (decoded(value + 1) - decoded(value - 1)) / 2
            expected, measured = math.sqrt(0.04**2 + slope**2 / 12), decoded(found).std(ddof=1)
        else:
            expected, measured = math.sqrt((0.04 * 255) ** 2 + 1 / 12), found.std(ddof=1)
        # The curve bends over some σ: 1 % of what rounding adds, which is 0.1 % itself.
        what = "σ of the linear light, --linear" if light else "σ of the codes"
        figures.append(Figure(what, measured, expected, error_of_sigma(expected, 3) + 1e-3 * expected, "NumPy"))
    return figures


def channels(tool):
    picture = np.full((*SIZE, 3), 100.0)
    figures = []
    for way, expected in (("independent", 0), ("common", 1)):
        found = add(tool, picture, f"channels={way}", "gaussian.sigma=4")
        r, g = found[..., 0].ravel(), found[..., 1].ravel()
        figures.append(
            Figure(f"correlation of R and G, {way}", np.corrcoef(r, g)[0, 1], expected, 5 / math.sqrt(COUNT), "NumPy")
        )
    return figures


def expose(tool, light, *changes, unit=("electrons",), one=1, frames=1):
    """Raw numbers that the plain sensor makes of even light, less the black level, in electrons: an image a frame."""
    np.save(tool.scratch / "light.npy", np.asarray(light, np.float32))
    keys = [part for change in changes for part in ("--set", change)]
    time = [] if any(change.startswith("exposure.time_s") for change in changes) else ["--set", "exposure.time_s=0.01"]
    tool.run(
        "expose", "light.npy", "-o", "exposed", "--force", "--quiet", "--unit", *unit, "--one", one,
        "--frames", frames, "--set", f"sensor.preset={tool.capture('plain-sensor.toml')}",
        "--set", 'output.raw=["npy"]', *time, *keys,
    )  # fmt: skip
    files = sorted((tool.scratch / "exposed").glob("raw*.npy"))
    return np.array([(np.load(file).astype(float) - BLACK) / GAIN for file in files])


def sensor_even(value):
    return np.full(SENSOR_SIZE, value)


#: Variance that whole numbers add, in (e⁻)².
ROUNDING = 1 / 12 / GAIN**2


def shot_noise(tool):
    figures = []
    for mean in (100, 4000):
        found = expose(tool, sensor_even(mean))[0]
        within = 5 * mean * math.sqrt((2 + 1 / mean) / SENSOR_COUNT)
        figures.append(Figure(f"mean at {mean} e⁻", found.mean(), mean, 5 * math.sqrt(mean / SENSOR_COUNT)))
        figures.append(Figure(f"variance at {mean} e⁻", found.var(ddof=1), mean + ROUNDING, within, "Poisson"))
    return figures


def whole_sensor(tool):
    """An image of irradiance, exposed: photons, quantum efficiency, Poisson and read noise, gain."""
    irradiance, wavelength, time, read = 5e-3, 550, 0.02, 12.0
    planck, light = 6.62607015e-34, 299792458.0
    photons = irradiance * (5e-6) ** 2 * time * wavelength * 1e-9 / (planck * light)
    found = expose(
        tool, sensor_even(1), f"sensor.noise.read_noise_e={read}", f"exposure.time_s={time}",
        unit=("irradiance", "--wavelength-nm", wavelength), one=irradiance,
    )[0]  # fmt: skip
    electrons = 0.6 * photons
    variance = electrons + read**2 + ROUNDING
    return [
        Figure("mean, e⁻", found.mean(), electrons, 5 * math.sqrt(variance / SENSOR_COUNT)),
        Figure("variance, (e⁻)²", found.var(ddof=1), variance, 5 * variance * math.sqrt(2 / SENSOR_COUNT)),
    ]


def lux(tool):
    """An image of an illuminance of D65 on a sensor that sees 400 to 700 nm."""
    illuminance, time = 2.0, 0.01
    (tool.scratch / "qe.csv").write_text("wavelength_nm,value\n300,0\n399,0\n400,0.6\n700,0.6\n701,0\n1100,0\n")
    efficiency = 'sensor.channels.Y.quantum_efficiency={ file = "qe.csv" }'
    found = expose(tool, sensor_even(1), efficiency, f"exposure.time_s={time}", unit=("lux",), one=illuminance)[0]
    every_nm = colour.SpectralShape(360, 830, 1)
    daylight = colour.SDS_ILLUMINANTS["D65"].copy().align(every_nm)
    eye = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(every_nm).values[:, 1]
    irradiance = daylight.values * illuminance / (683 * (daylight.values * eye).sum())
    planck, light = 6.62607015e-34, 299792458.0
    seen = (daylight.wavelengths >= 400) & (daylight.wavelengths <= 700)
    rate = (irradiance * 0.6 * seen * (5e-6) ** 2 * daylight.wavelengths * 1e-9 / (planck * light)).sum()
    expected = rate * time
    # Between the 5 nm of the tables both interpolate, in their own way: 0.1 %.
    within = 5 * math.sqrt(expected / SENSOR_COUNT) + 1e-3 * expected
    return [Figure("mean, e⁻", found.mean(), expected, within, "colour-science")]


def own_read_noise(tool):
    read, spread, frames = 20.0, 0.5, 24
    found = expose(
        tool, sensor_even(0), f"sensor.noise.read_noise_e={read}", f"sensor.noise.read_noise_spread_percent={100 * spread}",
        frames=frames,
    )  # fmt: skip
    logarithms = np.log(found.var(axis=0, ddof=1) - ROUNDING)
    # σ_i = σ·exp(t·n − t²) with t² = ln(1 + s²); that of a sample has ψ′(k/2) besides.
    t2, half = math.log(1 + spread**2), (frames - 1) / 2
    variance = 4 * t2 + float(stats.loggamma(half).var())
    mean = 2 * math.log(read) - 2 * t2 + float(stats.loggamma(half).mean()) - math.log(half)
    return [
        Figure("mean of ln σ̂²", logarithms.mean(), mean, 5 * math.sqrt(variance / SENSOR_COUNT), "SciPy"),
        Figure(
            "variance of ln σ̂²", logarithms.var(), variance, 5 * variance * math.sqrt(2 / SENSOR_COUNT) + 0.01, "SciPy"
        ),
    ]


def dark_current(tool):
    keys = [
        "sensor.noise.dark_current_e_per_s=200", "sensor.noise.dark_current_reference_c=25",
        "sensor.noise.dark_current_doubling_k=8", "exposure.time_s=2",
    ]  # fmt: skip
    figures = []
    for celsius, expected in ((25, 400), (33, 800)):
        found = expose(tool, sensor_even(0), *keys, f"exposure.temperature_c={celsius}")[0]
        within = 5 * math.sqrt(expected / SENSOR_COUNT)
        figures.append(Figure(f"mean at {celsius} °C, e⁻", found.mean(), expected, within))
        variance = expected + ROUNDING
        within = 5 * variance * math.sqrt(2 / SENSOR_COUNT)
        figures.append(Figure(f"variance at {celsius} °C", found.var(ddof=1), variance, within, "Poisson"))
    return figures


def fixed_patterns(tool):
    figures = []
    for key, light, sigma in (("prnu_percent=2", 5000, 100), ("dsnu_e=30", 0, 30)):
        frames = 16
        found = expose(tool, sensor_even(light), f"sensor.noise.{key}", frames=frames)
        # What averaging leaves of shot noise and rounding.
        left = (light + ROUNDING) / frames
        measured = math.sqrt(found.mean(axis=0).var(ddof=1) - left)
        within = 5 * (sigma**2 + left) * math.sqrt(2 / SENSOR_COUNT) / (2 * sigma)
        figures.append(Figure(f"σ of the pattern, {key.split('=')[0]}, e⁻", measured, sigma, within, "NumPy"))
    return figures


def reset_noise(tool):
    capacitance, kelvin = 5e-15, 298.15
    expected = math.sqrt(1.380649e-23 * kelvin * capacitance) / 1.602176634e-19
    found = expose(tool, sensor_even(0), "sensor.noise.reset.capacitance_ff=5", "exposure.temperature_c=25")[0]
    measured = math.sqrt(found.var(ddof=1) - ROUNDING)
    return [Figure("σ, e⁻", measured, expected, error_of_sigma(expected, 3, SENSOR_COUNT), "√(kTC)/e")]


def quantisation(tool):
    """A ramp over many steps, without other noise: what rounding adds."""
    keys = ["exposure.stages_off=['shot-noise']"]
    ramp = np.linspace(200, 900, SENSOR_COUNT).reshape(SENSOR_SIZE)
    found = expose(tool, ramp, *keys)[0]
    step = 1 / GAIN
    error = found - ramp.astype(np.float32)
    within = 5 * step**2 / 12 * math.sqrt(0.8 / SENSOR_COUNT)
    return [Figure("variance of the error, (e⁻)²", error.var(), step**2 / 12, within, "q²/12")]


def kinds(tool):
    """The image: each kind on a ramp."""
    ramp = np.tile(np.linspace(0, 255, 180), (84, 1))
    shown = [
        ("gaussian", ["gaussian.sigma=20"]),
        ("laplacian", ["laplacian.sigma=20"]),
        ("uniform", ["uniform.sigma=20"]),
        ("multiplicative", ["gaussian.sigma=0.2", "gaussian.multiplicative=true"]),
        ("speckle, C = 1/2", ["speckle.contrast=0.5"]),
        ("salt and pepper", ["salt_and_pepper.part=0.08", "full_scale=255"]),
        ("film grain, length 2 px", ["film_grain.factor=2", "film_grain.exponent=0.5", "film_grain.correlation_px=2"]),
        ("film grain, length 0", ["film_grain.factor=2", "film_grain.exponent=0.5", "film_grain.correlation_px=0"]),
    ]
    sheet = Image.new("L", (4 * 184, 2 * 104), 255)
    draw = ImageDraw.Draw(sheet)
    for i, (name, keys) in enumerate(shown):
        x, y = 184 * (i % 4) + 2, 104 * (i // 4)
        found = add(tool, ramp, *keys).clip(0, 255).astype(np.uint8)
        sheet.paste(Image.fromarray(found), (x, y + 16))
        draw.text((x + 2, y + 2), name, fill=0)
    # Few grey levels: noise does not compress.
    sheet.quantize(16).save(tool.picture("noise-kinds.png"), optimize=True)


def gaussian(tool):
    kinds(tool)
    return additive("gaussian")(tool)


COMMAND = "photosite noise add f.png -o g.png --set "
EXPOSE = "photosite expose light.npy --unit electrons --set sensor.preset=plain-sensor.toml "
ROWS = [
    Row("Additive, Gaussian", "g = f + n, kurtosis 3", COMMAND + "gaussian.sigma=4", gaussian, "noise-kinds.png"),
    Row(
        "Additive, Laplacian",
        "p(n) = exp(−√2·|n|/σ)/(√2·σ), kurtosis 6",
        COMMAND + "laplacian.sigma=4",
        additive("laplacian"),
    ),
    Row("Additive, uniform", "|n| ≤ √3·σ, kurtosis 9/5", COMMAND + "uniform.sigma=4", additive("uniform")),
    Row("Multiplicative", "g = f·(1 + n), σ_g = σ·f", COMMAND + "gaussian.multiplicative=true", multiplicative),
    Row(
        "Salt and pepper",
        "g = white or black with the probability p",
        COMMAND + "salt_and_pepper.part=0.1",
        salt_and_pepper,
    ),
    Row("Speckle", "g = f·s, σ_g² = C²·f²", COMMAND + "speckle.contrast=0.5", speckle),
    Row(
        "Film grain",
        "g = f + c·f^γ·n, σ_g² = c²·f^(2γ), ρ = exp(−d²/(2ℓ²))",
        COMMAND + "film_grain.factor=0.8",
        film_grain,
    ),
    Row("σ of each pixel", "g = f + σ(x, y)·n", COMMAND + "sigma_map.file=sigma.npy", sigma_map),
    Row("Codes of 8 bits", "g rounded, 0 ≤ g ≤ 255", COMMAND + "laplacian.sigma=20", codes),
    Row("On codes, on linear light", "σ of g, σ of decoded g", COMMAND + "gaussian.sigma=0.04 --linear", linear_light),
    Row("Colour channels", "ρ(n_R, n_G) = 0 or 1", COMMAND + "channels=common", channels),
    Row("Photon noise", "σ² = μ", EXPOSE, shot_noise),
    Row(
        "An image on a whole sensor",
        "μ = η·E·A·t·λ/(hc), σ² = μ + σ_r² + q²/12",
        "photosite expose light.npy --unit irradiance",
        whole_sensor,
    ),
    Row(
        "An image of an illuminance",
        "E_v = 683·∫V·E dλ, μ = ∫η·E·A·t·λ/(hc) dλ",
        "photosite expose light.npy --unit lux",
        lux,
    ),
    Row(
        "Read noise of each pixel",
        "σ_i = σ·exp(t·n − t²), ⟨σ_i²⟩ = σ²",
        EXPOSE + "--set sensor.noise.read_noise_spread_percent=50",
        own_read_noise,
    ),
    Row(
        "Dark current",
        "μ_d = I·t·2^(ΔT/8 K), σ² = μ_d",
        EXPOSE + "--set sensor.noise.dark_current_e_per_s=200",
        dark_current,
    ),
    Row(
        "Fixed patterns",
        "PRNU: σ ∝ μ; DSNU: σ without light",
        EXPOSE + "--set sensor.noise.prnu_percent=2",
        fixed_patterns,
    ),
    Row("Reset noise", "σ = √(kTC)/e", EXPOSE + "--set sensor.noise.reset.capacitance_ff=5", reset_noise),
    Row("Quantisation", "σ² = q²/12", EXPOSE, quantisation),
]
