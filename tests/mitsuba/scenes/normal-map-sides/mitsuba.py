"""The exported scene. No normal is seen from behind here, where the programs differ."""


def load(mitsuba, folder, export):
    return mitsuba.load_file(str(export("--approximate")))
