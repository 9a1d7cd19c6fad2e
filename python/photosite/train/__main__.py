"""``python -m photosite.train``: shards of a data set for training programs."""

from __future__ import annotations

import argparse
import sys
import warnings

from .._errors import Error, PhotositeWarning
from . import mcap, parquet, webdataset

FORMATS = {"webdataset": webdataset, "parquet": parquet, "mcap": mcap}


def main() -> int:
    """Runs the command, and returns its exit status: 1 where the data set or a folder cannot be used."""
    about = "Write a data set as shards for training programs; shards that are there already stay."
    parser = argparse.ArgumentParser(prog="python -m photosite.train", description=about)
    parser.add_argument("format", choices=sorted(FORMATS), help="WebDataset's tar files, Parquet of Hugging Face, MCAP of ROS 2")
    parser.add_argument("dataset", help="the folder that `photosite dataset` has filled")
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="the folder of the shards")
    size = parser.add_mutually_exclusive_group()
    size.add_argument("--shard-mb", type=int, metavar="MIB", help="most bytes of a shard [default: 256]")
    size.add_argument("--shard-frames", type=int, metavar="N", help="frames of a shard, however large they are")
    given = parser.parse_args()
    write = FORMATS[given.format]
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("once", PhotositeWarning)
            written = write(given.dataset, given.output, shard_mb=given.shard_mb, shard_frames=given.shard_frames)
    except Error as error:
        print(f"error: {error}", file=sys.stderr)
        if error.help:
            print(f"  help: {error.help}", file=sys.stderr)
        return 1
    for warning in caught:
        print(f"warning: {warning.message}", file=sys.stderr)
    print(f"wrote {written} shard{'' if written == 1 else 's'} to {given.output}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
