"""How many samples of the documentation run, and how many rules of accessibility the documentation and the demo site violate."""

import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent


def samples():
    """Samples that some test executes or compiles (tests/samples/inventory.py says which), and the others."""
    sys.path.insert(0, str(ROOT / "tests/samples"))
    import inventory

    everything, _ = inventory.samples()
    run = sum(sample.is_run for sample in everything)
    return {"docs.samples_run": run, "docs.samples_not_run": len(everything) - run}


def accessibility(stream):
    """Pages of the demo site and of the documentation, at two widths, light and dark, by axe-core in Chromium."""
    docs = ROOT / "build/docs"
    if not docs.exists():
        subprocess.run(["node", ROOT / "js/docs/build.mjs", docs, ROOT / "build/default/tools"], check=True)
    done = subprocess.run(
        ["node", pathlib.Path(__file__).parent / "axe.mjs", docs, stream],
        capture_output=True,
        text=True,
    )
    if done.returncode:
        sys.exit(f"bench: the pages could not be looked at: {done.stderr[-2000:]}")
    return {"site.axe_violations": int(done.stdout)}
