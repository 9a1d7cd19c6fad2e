"""The exported scene, with glTF's metallic-roughness model, which Mitsuba does not have."""

import microfacets


def load(mitsuba, folder, export):
    return microfacets.load(mitsuba, export("--approximate"))
