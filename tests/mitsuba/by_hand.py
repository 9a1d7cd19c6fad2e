"""What scenes written by hand share: photosite's data files read anew, without its exporter.

A scene by hand says in Mitsuba's terms what its capture means. Only files of data are read: spectra, quantum efficiencies,
vertices. Units, geometry of the camera and photometry are worked out here from the definitions, so that a mistake which
photosite's loader and exporter share shows as a difference.
"""

import math
import tomllib
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
SPECTRA = ROOT / "crates" / "photosite-core" / "assets" / "spectra"
GEOMETRY = Path(__file__).resolve().parent / "geometry"
PLANCK, LIGHT_SPEED = 6.62607015e-34, 299792458.0
LUMENS_PER_WATT = 683.0
GRID = np.arange(300.0, 1101.0)


def at(path, wavelengths=GRID, column="value"):
    """A tabulated spectrum at wavelengths in nm, zero outside of its table unless the file says that it holds."""
    lines = Path(path).read_text(encoding="utf-8").splitlines()
    hold = any(line.replace(" ", "") == "#outside:hold" for line in lines)
    rows = [line.split(",") for line in lines if line and not line.startswith("#")]
    columns = dict(zip(rows[0], np.array([[float(field) for field in row] for row in rows[1:]]).T))
    outside = {} if hold else {"left": 0.0, "right": 0.0}
    return np.interp(wavelengths, columns["wavelength_nm"], columns[column], **outside)


def regular(values):
    """A spectrum given on the grid."""
    if not np.any(values):
        return {"type": "uniform", "value": 0.0}
    return {
        "type": "regular",
        "wavelength_min": float(GRID[0]),
        "wavelength_max": float(GRID[-1]),
        "values": ",".join(f"{value:.9g}" for value in np.broadcast_to(values, GRID.shape)),
    }


def photometric(shape, level):
    """A spectrum of that shape whose luminous quantity (nit, candela, lux) is `level`."""
    efficiency = at(SPECTRA / "cie-1931-2deg.csv", column="y")
    return shape * level / (LUMENS_PER_WATT * np.trapezoid(shape * efficiency, GRID))


def illuminant_a():
    """CIE 15: a Planckian radiator of 2848 K by the c2 of 1.435e-2 m·K in use then."""
    return 100 * (560 / GRID) ** 5 * np.expm1(1.435e7 / (2848 * 560)) / np.expm1(1.435e7 / (2848 * GRID))


def film(preset, columns, rows, pitch_um, f_number, focal_length, image_distance, seconds):
    """A film that counts electrons: QE·λ/(hc) · filter · pixel area · π·sin²θ' · time, tan θ' = D/2v, without falloff."""
    path = ROOT / "crates" / "photosite-sensor" / "assets" / "sensors" / f"{preset}.toml"
    sensor = tomllib.loads(path.read_text(encoding="utf-8"))
    filter_ = at(path.parent / sensor["filter"]["transmittance"]["file"]) if "filter" in sensor else 1.0
    per_joule = GRID * 1e-9 / (PLANCK * LIGHT_SPEED) * sensor["fill_factor"] * filter_
    aperture = math.pi * math.sin(math.atan(focal_length / f_number / 2 / image_distance)) ** 2
    factor = per_joule * (pitch_um * 1e-6) ** 2 * aperture * seconds
    responses = {
        name: regular(at(path.parent / channel["quantum_efficiency"]["file"]) * factor)
        for name, channel in sensor["channels"].items()
    }
    film = {"type": "specfilm", "width": columns, "height": rows, "rfilter": {"type": "box"}, "component_format": "float32"}
    return film | responses


def camera(mitsuba, kind, position, target, width_m, image_distance, film, **others):
    """A camera whose image is width_m wide, image_distance behind the lens; metres."""
    return {
        "type": kind,
        "fov_axis": "x",
        "fov": math.degrees(2 * math.atan(width_m / 2 / image_distance)),
        "near_clip": 1e-3,
        "far_clip": 1e4,
        "to_world": mitsuba.ScalarTransform4f().look_at(position, target, [0, 1, 0]),
        "sampler": {"type": "independent"},
        "film": film,
    } | others


def diffuse(reflectance):
    """Lambert's law on both sides."""
    return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": regular(reflectance)}}


def polygons(path):
    """Corners of the polygons of an OBJ file, with the names of their materials."""
    vertices, found, material = [], [], None
    for line in Path(path).read_text(encoding="utf-8").splitlines():
        word, *rest = line.split() or [""]
        if word == "v":
            vertices.append([float(number) for number in rest[:3]])
        elif word == "usemtl":
            material = rest[0]
        elif word == "f":
            indices = [int(corner.split("/")[0]) for corner in rest]
            found.append((material, [vertices[i - 1 if i > 0 else i] for i in indices]))
    return found


def write_obj(path, faces):
    """An OBJ file of polygons that share no corners."""
    lines, n = [], 0
    for corners in faces:
        lines += ["v " + " ".join(f"{c:.9g}" for c in corner) for corner in corners]
        lines.append("f " + " ".join(str(n + k + 1) for k in range(len(corners))))
        n += len(corners)
    Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")


def shapes(folder, scratch, files, materials, scale=1.0):
    """Flat-shaded meshes of OBJ files, one for each material: {name: (bsdf, emitter or None)}."""
    faces = {}
    for file in files:
        for material, corners in polygons(folder / file):
            faces.setdefault(material, []).append([[c * scale for c in corner] for corner in corners])
    made = {}
    for name, all_of_it in faces.items():
        path = scratch / f"{name}.obj"
        write_obj(path, all_of_it)
        bsdf, emitter = materials[name]
        made[f"shape-{name}"] = {"type": "obj", "filename": str(path), "face_normals": True, "bsdf": bsdf}
        if emitter is not None:
            made[f"shape-{name}"]["emitter"] = {"type": "area", "radiance": regular(emitter)}
    return made
