"""A simulated block with its control patches, runs of the program, and comparisons of their output,
for tests and benchmarks that run the program from outside.
"""

import subprocess
import sys

# Small digital photos: about two seconds of exterior orientation each.
SMALL_DIGITAL = ("--camera-preset", "digital", "--pixel-size-um", 60, "--gsd-m", 0.8,
                 "--relief-m", 50)
# These depend on the run, not only on the block.
OF_THE_RUN = {"run.json", "report.html", "block.gpkg", "block.qgz", "not_yet_learnt"}
FOLDERS_OF_THE_RUN = {"slurm", "report_photos"}


def run(*words, codes=(0,)):
    """Returns the completed process; exits if its exit code is not one of `codes`."""
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    if done.returncode not in codes:
        sys.exit(f"{' '.join(map(str, words))}: {done.returncode}\n{done.stdout}{done.stderr}")
    return done


def harvest(orient, folder, *options):
    """Creates patches.gpkg afresh."""
    database, old = folder / "patches.gpkg", folder / "old"
    database.unlink(missing_ok=True)
    run(orient, "patchdb", "create", database, "--crs", "EPSG:32635")
    run(orient, "patchdb", "harvest", database, "--camera", old / "camera.toml",
        "--orientation", old / "orientation.csv", "--interior", old / "interior",
        "--dem", folder / "dem.tif", *options, *sorted((old / "photos").glob("*.tif")))


def make_block(orient, folder, photos, *options):
    """`options` are those of `orient simulate`."""
    run(orient, "simulate", "--out", folder, "--photos", photos, *options)
    harvest(orient, folder)


def contents(out):
    return {str(path.relative_to(out)): path.read_bytes() for path in sorted(out.rglob("*"))
            if path.is_file() and path.name not in OF_THE_RUN
            and path.relative_to(out).parts[0] not in FOLDERS_OF_THE_RUN}


def complaints_about_difference(one, many):
    """Differences between the output of two runs; prints how many files were compared."""
    expected, made = contents(one), contents(many)
    other = sorted(name for name in expected.keys() | made.keys()
                   if expected.get(name) != made.get(name))
    print(f"{len(other)} of {len(expected)} files differ from those of one run on one machine")
    return ([] if expected else ["nothing was made"]) + other
