"""A capture in Mitsuba 3, inside this process."""

import ctypes
import glob
import os
import resource
import subprocess
import sys
import time
import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np

# Samples of one render call: more would take more memory than they are worth.
PART = 256


class Mitsuba:
    """A capture as Mitsuba renders it, exported by `photosite export-mitsuba`."""

    def __init__(self, mitsuba, photosite, capture, folder, sampler, threads):
        self.mitsuba, self.sampler, self.threads, self.name = mitsuba, sampler, threads, f"Mitsuba, {sampler}"
        out = folder / "mitsuba"
        if not (out / "scene.xml").is_file():
            # The shadowing of rough gold differs a little: --approximate.
            command = [str(photosite), "export-mitsuba", str(capture), "-o", str(out), "--quiet", "--approximate"]
            if subprocess.run(command, check=False, stderr=subprocess.DEVNULL).returncode:
                sys.exit("photosite cannot export the capture")
        tree = xml.parse(out / "scene.xml")
        tree.find("sensor/sampler").set("type", sampler)
        self.file = out / f"{sampler}.xml"
        tree.write(self.file)
        self.scene = mitsuba.load_file(str(self.file))

    def render(self, samples, seed):
        """An image, mean electrons, with the wall and processor seconds of its light transport."""
        import drjit

        wall, busy = time.perf_counter(), time.process_time()
        picture = self.mitsuba.render(self.scene, spp=samples, seed=seed)
        drjit.eval(picture)
        drjit.sync_thread()
        seconds = time.perf_counter() - wall, time.process_time() - busy
        return np.array(picture, dtype=np.float64), seconds

    def warm_up(self, samples):
        """Traces and compiles the scene's kernel, which no measured render has to."""
        self.render(samples, 0)

    def whole_program(self, samples, seed):
        """Wall and processor seconds of a program that renders the scene: start, loading, kernel from Dr.Jit's cache, light, file."""
        program = [sys.executable, "-m", "comparison.mitsuba_renderer", self.file, self.mitsuba.variant(), samples, seed, self.threads or 0]
        environment = dict(os.environ, PYTHONPATH=str(Path(__file__).resolve().parents[1]))
        before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        subprocess.run([str(word) for word in program], check=True, env=environment)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return time.perf_counter() - start, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    def reference(self, samples):
        """An image of many samples."""
        parts = max(1, samples // PART)
        return sum(self.render(min(PART, samples), 1_000_000 + i)[0] for i in range(parts)) / parts


def keep_to_avx2(drjit):
    """Lets Mitsuba compile its kernels as on a machine that has AVX2 and no AVX-512."""
    core = ctypes.CDLL(str(Path(drjit.__file__).with_name("libdrjit-core.so")))
    # jit_llvm_set_target(processor, features, numbers in a vector): not among what Dr.Jit shows to Python.
    set_target = core._Z19jit_llvm_set_targetPKcS0_j
    set_target.argtypes = [ctypes.c_char_p, ctypes.c_char_p, ctypes.c_uint32]
    set_target(b"haswell", b"+avx2,+fma,+bmi2,+f16c", 8)


def start(variant, threads, avx2=False):
    """Imports Mitsuba in a variant, if asked to keep to AVX2."""
    # Mitsuba finds LLVM when its backend starts, by this variable or the loader's default names.
    if "llvm" in variant and "DRJIT_LIBLLVM_PATH" not in os.environ:
        found = sorted(glob.glob("/usr/lib/*/libLLVM.so.19*") + glob.glob("/usr/lib/llvm-19/lib/libLLVM*.so*"))
        if found:
            os.environ["DRJIT_LIBLLVM_PATH"] = found[0]
    import drjit
    import mitsuba

    if variant not in mitsuba.variants():
        sys.exit(f"Mitsuba has no variant {variant}; it has {', '.join(mitsuba.variants())}")
    mitsuba.set_variant(variant)
    if avx2:
        keep_to_avx2(drjit)
    if threads:
        # Mitsuba up to 3.7 has threads of its own beside those of Dr.Jit.
        drjit.set_thread_count(threads)
        own = getattr(mitsuba.Thread, "set_thread_count", None)
        if own is not None:
            own(threads)
    return mitsuba


def read_exr(mitsuba):
    """A reader of EXR files: names of channels, and height × width × channels."""

    def read(path):
        bitmap = mitsuba.Bitmap(str(path))
        names = [field.name for field in bitmap.struct_()]
        return names, np.array(bitmap, dtype=np.float64).reshape(bitmap.height(), bitmap.width(), -1)

    return read


def main():
    """Renders a scene once, as a user's own program does."""
    file, variant, samples, seed, threads = sys.argv[1:]
    mitsuba = start(variant, int(threads))
    picture = mitsuba.render(mitsuba.load_file(file), spp=int(samples), seed=int(seed))
    mitsuba.Bitmap(picture).write(str(Path(file).with_suffix(".exr")))


if __name__ == "__main__":
    main()
