"""A block in a notebook: cells begin with `# %%`, as understood by Jupyter, VS Code and Spyder.

Needs the package `orient`, and NumPy. Works in the current folder: run it in an empty one.
"""
# %% A small block with known truth, and control patches from older photos of the same area
import glob

import numpy as np

import orient

orient.run("simulate", out="flight", photos=3, camera_preset="digital", pixel_size_um=60,
           gsd_m=0.75, relief_m=50, seed=3)
orient.run("patchdb", "create", "flight/patches.gpkg", crs="EPSG:32635")
orient.run("patchdb", "harvest", "flight/patches.gpkg", *sorted(glob.glob("flight/old/photos/*.tif")),
           camera="flight/old/camera.toml", orientation="flight/old/orientation.csv",
           interior="flight/old/interior", dem="flight/dem.tif")

# %% Orient it, and print the progress
orient.run("block", "flight/block.toml",
           progress=lambda task, done, total: print(f"{task}: {done} of {total}"))
block = orient.Block("flight/out")
for photo in block.photos:
    print(photo.photo, photo.status, *photo.findings, sep="\n  ")

# %% Normalised errors: true errors, known from the simulation, over their stated sigmas
truth = orient.read_poses("flight/truth/orientation.csv")
order = [truth.photos.index(name) for name in block.names]
errors = np.hstack([block.positions - truth.positions[order], block.angles - truth.angles[order]])
sigmas = np.sqrt(np.diagonal(block.covariances, axis1=1, axis2=2))
print(np.round(errors / sigmas, 2))

# %% From the ground into a photo, and back
name = block.names[0]
geometry = block.geometry(name)
surface = orient.Surface("flight/dem.tif", block.crs)
patches = block[name].patches
matched = np.array(patches["state"]) == "matched"
pixels = geometry.pixels(patches["ground_m"][matched])
print("residuals of the patches [px]:", np.std(patches["pixel"][matched] - pixels, axis=0))
corners = np.array([[0, 0], [block[name].width, 0], [block[name].width, block[name].height],
                    [0, block[name].height]])
print("the photo's corners on the ground:", geometry.ground(corners, surface), sep="\n")
