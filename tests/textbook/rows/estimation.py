"""Estimates of noise, against NumPy and SciPy on the same files."""

import math
import shutil

import numpy as np
from scipy import stats
from table import Figure, Row

SIZE = (96, 128)
PICTURES = 8
SIDE = 8


def scene(tool):
    """Images of a shaded scene with a fixed pattern and smoothed noise; gives them as they are in the files."""
    random = np.random.default_rng(5)
    rows, columns = np.indices(SIZE)
    pattern = random.normal(0, 3, SIZE)
    pictures = []
    for i in range(PICTURES):
        white = random.normal(0, 5, (SIZE[0], SIZE[1] + 1))
        # A mean of two neighbours along the row.
        noise = (white[:, :-1] + white[:, 1:]) / 2
        picture = (400 + 0.2 * columns - 0.1 * rows + pattern + noise).astype(np.float32)
        np.save(tool.scratch / f"take{i}.npy", picture)
        pictures.append(picture.astype(float))
    return np.array(pictures)


def files(count=PICTURES):
    return [f"take{i}.npy" for i in range(count)]


def estimate(tool, count=PICTURES, *options):
    return tool.json("noise", *files(count), "--square", SIDE, *options)["planes"][0]


def near(what, measured, expected, by="NumPy"):
    """Two programs, the same sums in double precision."""
    return Figure(what, measured, expected, 1e-9 * max(1, abs(expected)), by)


def plane(values):
    """Coefficients of c + a·x + b·y about the middle, and residuals."""
    rows, columns = np.indices(values.shape)
    design = np.stack([np.ones(values.size), columns.ravel() - columns.mean(), rows.ravel() - rows.mean()], 1)
    coefficients, *_ = np.linalg.lstsq(design, values.ravel(), rcond=None)
    return coefficients, values.ravel() - design @ coefficients


def several(tool):
    pictures = scene(tool)
    sigma = np.std(pictures, axis=0, ddof=1)
    temporal = estimate(tool)["temporal"]
    return [
        near("σ, root of the mean of σ²", temporal["noise"]["sigma"], math.sqrt((sigma**2).mean())),
        near("σ̄, mean of all pixels", temporal["map"]["mean"], sigma.mean()),
        near("σ_max, the worst pixel", temporal["largest_sigma"], sigma.max()),
    ]


def sigma_map(tool):
    pictures = scene(tool)
    sigma = np.std(pictures, axis=0, ddof=1)
    tool.run("noise", *files(), "--sigma-map", "sigma.npy", "--plots", "plots")
    shutil.copy(tool.scratch / "plots/Y-sigma-map.png", tool.picture("noise-sigma-map.png"))
    found = np.load(tool.scratch / "sigma.npy")
    temporal = estimate(tool)["temporal"]
    freedom = PICTURES - 1
    pooled = (sigma**2).mean()
    distance = stats.kstest(freedom * sigma.ravel() ** 2 / pooled, stats.chi2(freedom).cdf).statistic
    expected_spread = math.sqrt(pooled) * stats.chi(freedom).std() / math.sqrt(freedom)
    return [
        Figure("largest difference of a pixel", abs(found - sigma).max(), 0, 2.0**-24 * sigma.max(), "NumPy"),
        near("distance of (N − 1)·σ̂²/σ² from χ²", temporal["map"]["distance"], distance, "SciPy"),
        near("spread that χ gives", temporal["map"]["expected_spread"], expected_spread, "SciPy"),
    ]


def one_patch(tool):
    pictures = scene(tool)
    found = estimate(tool, 1)
    (_, a, b), left = plane(pictures[0])
    sigma = 4.65
    known = estimate(tool, 1, "--sigma", sigma)["plane"]["chi_squared"]
    chi, freedom = (left**2).sum() / sigma**2, left.size - 3
    return [
        near("σ of an even patch", found["uniform"]["sigma"], pictures[0].std(ddof=1)),
        near("slope along x", found["plane"]["slope"][0], a),
        near("slope along y", found["plane"]["slope"][1], b),
        near("σ after a plane", found["plane"]["noise"]["sigma"], math.sqrt((left**2).sum() / freedom)),
        near("χ²", known["value"], chi),
        near("degrees of freedom, n − 3", known["freedom"], freedom),
        Figure("probability", known["p_value"], stats.chi2(freedom).sf(chi), 1e-8, "SciPy"),
    ]


def neighbourhoods(tool):
    pictures = scene(tool)
    squares = [
        picture[y : y + SIDE, x : x + SIDE]
        for picture in pictures[:1]
        for y in range(0, SIZE[0], SIDE)
        for x in range(0, SIZE[1], SIDE)
    ]
    freedom = SIDE**2 - 3
    variances = np.array([(plane(square)[1] ** 2).sum() / freedom for square in squares])
    sigmas = np.sqrt(variances)
    found = estimate(tool, 1)["neighbourhoods"]
    known = estimate(tool, 1, "--sigma", 4.5)["neighbourhoods"]["chi_squared"]
    tool.run("noise", *files(1), "--square", SIDE, "--plots", "plots", "--force")
    shutil.copy(tool.scratch / "plots/Y-neighbourhoods.png", tool.picture("noise-neighbourhoods.png"))
    distance = stats.kstest(freedom * variances / variances.mean(), stats.chi2(freedom).cdf).statistic
    return [
        near("squares", found["sigmas"]["count"], len(squares)),
        near("mean of σ", found["sigmas"]["mean"], sigmas.mean()),
        near("spread of σ", found["sigmas"]["spread"], sigmas.std()),
        near("root of the mean of σ²", found["noise"]["sigma"], math.sqrt(variances.mean())),
        near("distance of k·σ̂²/σ² from χ²", found["sigmas"]["distance"], distance, "SciPy"),
        near("χ² of all, σ = 4.5", known["value"], freedom * variances.sum() / 4.5**2),
        near("degrees of freedom of all", known["freedom"], freedom * len(squares)),
    ]


def autocovariance(tool):
    pictures = scene(tool)
    lags = 6
    found = estimate(tool, PICTURES, "--lags", lags)["autocovariance"]
    tool.run("noise", *files(), "--lags", lags, "--plots", "plots", "--force")
    shutil.copy(tool.scratch / "plots/Y-autocovariance.png", tool.picture("noise-autocovariance.png"))
    e = (pictures - pictures.mean(axis=0)) * math.sqrt(PICTURES / (PICTURES - 1))

    def covariance(rows, columns):
        height, width = SIZE[0] - rows, SIZE[1] - columns
        return (e[:, :height, :width] * e[:, rows:, columns:]).mean()

    figures = [
        near(f"C({rows}, {columns})", found["covariances"][rows][columns], covariance(rows, columns))
        for rows, columns in ((0, 0), (0, 1), (0, 2), (1, 0), (3, 2))
    ]
    # A mean of two has half the variance, and its neighbours share half of that. 5 standard errors of a correlation.
    along = found["along_rows"]
    count = PICTURES * SIZE[0] * SIZE[1]
    return [*figures, Figure("C(0, 1)/C(0, 0) of means of two", along[1] / along[0], 0.5, 5 / math.sqrt(count))]


def signal_to_noise(tool):
    pictures = scene(tool)
    found = estimate(tool)["snr"]
    sigma = np.std(pictures, axis=0, ddof=1)
    noise, average = math.sqrt((sigma**2).mean()), pictures.mean(axis=0)
    signal = math.sqrt(average.var(ddof=1) - noise**2 / PICTURES)
    return [
        near("σ_s/σ_n", found["contrast"]["ratio"], signal / noise),
        near("10·log₁₀(σ_s/σ_n)", found["contrast"]["db_of_sigma"], 10 * math.log10(signal / noise)),
        near("20·log₁₀(σ_s/σ_n)", found["contrast"]["db"], 20 * math.log10(signal / noise)),
        near("20·log₁₀(μ/σ_n)", found["db"], 20 * math.log10(pictures.mean() / noise)),
        near("20·log₁₀(μ/σ_max)", found["worst_db"], 20 * math.log10(pictures.mean() / sigma.max())),
        near("log₂(μ/σ_n)", found["bits"], math.log2(pictures.mean() / noise)),
    ]


def rounding(tool):
    """Of whole numbers, the part of the variance that rounding has."""
    random = np.random.default_rng(7)
    for i in range(PICTURES):
        np.save(tool.scratch / f"take{i}.npy", random.normal(200, 2, SIZE).round().astype(np.uint16))
    found = estimate(tool)
    variance = np.var([np.load(tool.scratch / name).astype(float) for name in files()], axis=0, ddof=1).mean()
    # 4 + 1/12, known to √(2/degrees of freedom); 5 of them.
    expected = 4 + 1 / 12
    within = 5 * expected * math.sqrt(2 / ((PICTURES - 1) * SIZE[0] * SIZE[1]))
    return [
        Figure("variance", found["temporal"]["noise"]["variance"], expected, within),
        near("rounding's part, %", found["quantisation"]["part_percent"], 100 / 12 / variance),
    ]


ROWS = [
    Row(
        "Several images: EST_NOISE",
        "σ(i, j)² = Σ_k (E_k − Ē)²/(N − 1), σ̄ and max σ",
        "photosite noise a.png b.png …",
        several,
    ),
    Row(
        "σ map",
        "(N − 1)·σ̂²/σ² follows χ² of N − 1",
        "photosite noise a.png b.png … --sigma-map s.exr",
        sigma_map,
        "noise-sigma-map.png",
    ),
    Row("One patch, a plane", "σ² = Σr²/(n − 3), χ² = Σr²/σ₀²", "photosite noise a.png --sigma 4.65", one_patch),
    Row(
        "Many neighbourhoods",
        "a plane each, k·σ̂²/σ² follows χ² of k = s² − 3",
        "photosite noise a.png --square 8",
        neighbourhoods,
        "noise-neighbourhoods.png",
    ),
    Row(
        "AUTO_COVARIANCE",
        "C(r, c) = ⟨e(i, j)·e(i + r, j + c)⟩",
        "photosite noise a.png b.png … --lags 6 --plots plots",
        autocovariance,
        "noise-autocovariance.png",
    ),
    Row(
        "Signal over noise", "σ_s/σ_n in 10·log₁₀ and 20·log₁₀, μ/σ_n", "photosite noise a.png b.png …", signal_to_noise
    ),
    Row("Rounding", "q²/12 of the variance", "photosite noise a.png b.png …", rounding),
]
