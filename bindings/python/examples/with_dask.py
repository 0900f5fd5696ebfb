"""Packs a capture with the processes of Dask: a task for each group of frames, and the same bytes as a single run.

usage: python with_dask.py CAPTURE OUT.fvv [WORKERS]
"""

import os
import sys
import tempfile

import fvv
import fvv.distributed


def main(capture, out, workers="2"):
    from dask.distributed import Client, LocalCluster

    options = {"group": 4, "max_error": "5mm"}
    # On a cluster: Client("tcp://scheduler:8786"), and paths or URLs that all of its machines reach.
    with (
        LocalCluster(n_workers=int(workers), threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        result = fvv.distributed.mux(capture, out, client, force=True, **options)
    print(f"{result['frames']} frames in {result['groups']} tasks, {result['bytes']} bytes")

    with tempfile.TemporaryDirectory() as folder:
        alone = os.path.join(folder, "alone.fvv")
        fvv.mux(capture, alone, **options)
        with open(alone, "rb") as one, open(out, "rb") as other:
            print("the same bytes as a single run:", one.read() == other.read())


if __name__ == "__main__":
    main(*sys.argv[1:])
