root=$PWD
(cd "$SCRATCH" && python torch+wheel -m pytest -q -p no:cacheprovider "$root/python/tests/test_torch.py")
python torch+wheel docs/notebooks/run.py train-a-denoiser
