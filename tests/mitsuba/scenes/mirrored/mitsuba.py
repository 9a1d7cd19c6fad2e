"""The exported scene with glTF's material as published. No normal is seen from behind here, where the programs differ."""

import microfacets


def load(mitsuba, folder, export):
    return microfacets.load(mitsuba, export("--approximate"))
