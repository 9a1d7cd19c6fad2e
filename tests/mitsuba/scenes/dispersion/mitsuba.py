"""One scene for each wavelength, in which glass has the index that it has there."""

import xml.etree.ElementTree as ElementTree

import microfacets

# Wavelengths of the channels, nm.
CHANNELS = {"R": 620, "G": 540, "B": 450}


def index_of_n_sf11(nm):
    """Sellmeier's formula with the coefficients of SCHOTT's catalogue."""
    squared = (nm * 1e-3) ** 2
    terms = (1.73759695, 0.013188707), (0.313747346, 0.0623068142), (1.89878101, 155.23629)
    return (1 + sum(b * squared / (squared - c) for b, c in terms)) ** 0.5


def load(mitsuba, folder, export):
    exported = export("--approximate")
    scenes = []
    for channel, nm in CHANNELS.items():
        tree = ElementTree.parse(exported)
        film = tree.find("sensor/film")
        for response in film.findall("spectrum"):
            if response.get("name") != channel:
                film.remove(response)
        for glass in tree.findall(".//float[@name='int_ior']"):
            glass.set("value", str(index_of_n_sf11(nm)))
        path = exported.with_name(f"{nm}.xml")
        tree.write(path)
        scenes.append(microfacets.load(mitsuba, path))
    return scenes
