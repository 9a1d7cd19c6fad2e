"""The exported scene, with the height-correlated shadowing of microfacets that Mitsuba does not have."""

import microfacets


def load(mitsuba, folder, export):
    return microfacets.load(mitsuba, export("--approximate"))
