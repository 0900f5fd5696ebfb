"""200 seeded orders of failures, deaths and other versions on a cluster of two workers (cluster_orders.py)."""

import cluster_orders
from conftest import tool


def test_two_hundred_orders(tmp_path):
    found, wrong = cluster_orders.figures(200, tmp_path, tool)
    assert wrong == [] and found["dask.hangs"] == 0 and found["dask.orders"] == 200, found
    assert all(
        found[f"dask.orders_{end}"] >= 10 for end in ("identical", "storage", "damaged", "version")
    ), found
