"""Frames of a clip as samples, read by worker processes: of PyTorch's DataLoader, or without torch of a ProcessPoolExecutor.

usage: python data_loader.py CLIP.fvv [WORKERS]
"""

import sys

import fvv
import numpy


class Surfaces:
    """A map-style data set: what torch.utils.data.DataLoader takes. Each worker process opens the clip for itself."""

    def __init__(self, path):
        self.clip = fvv.open(path)

    def __len__(self):
        return len(self.clip)

    def __getitem__(self, index):
        frame = self.clip[index]
        picture = next(iter(frame.pictures.values()))
        # Arrays are read-only views; torch wants memory that it may write to.
        return {
            "time": frame.time,
            "centre": frame.mesh.positions.mean(axis=0),
            "pixels": numpy.array(picture.pixels),
        }


def samples_of(dataset, workers):
    """The samples in order, from worker processes."""
    try:
        from torch.utils.data import DataLoader
    except ImportError:
        print("torch is not installed: the workers are those of a ProcessPoolExecutor")
        from concurrent.futures import ProcessPoolExecutor

        with ProcessPoolExecutor(workers) as pool:
            yield from pool.map(dataset.__getitem__, range(len(dataset)))
    else:
        # Tiles of the video may differ in size from group to group, and a batch has one size: one sample each.
        yield from DataLoader(dataset, batch_size=None, num_workers=workers)


def main(path, workers="2"):
    dataset = Surfaces(path)
    count, brightest = 0, 0
    for sample in samples_of(dataset, int(workers)):
        count += 1
        brightest = max(brightest, int(numpy.asarray(sample["pixels"]).max()))
    print(f"{count} samples, the brightest pixel is {brightest}")


if __name__ == "__main__":
    main(*sys.argv[1:])
