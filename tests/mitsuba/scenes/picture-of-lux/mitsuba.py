"""The exported scene; between texels, Mitsuba interpolates spectra in seventh parts of a texel where photosite does RGB."""


def load(mitsuba, folder, export):
    return mitsuba.load_file(str(export("--approximate")))
