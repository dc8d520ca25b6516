#!/usr/bin/env python3
"""CTest `qgis`: QGIS itself opens block.qgz and block.gpkg and shows them as intended.

    qgis_test.py ORIENT [PICTURE.png]   PICTURE.png: where to keep the picture of the map

Skipped (77) without Debian's python3-qgis.
"""

import os
import pathlib
import shutil
import sys
import tempfile

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
SKIPPED = 77
try:
    from qgis.PyQt.QtCore import QSize
    from qgis.core import (QgsApplication, QgsCategorizedSymbolRenderer, QgsExpression,
                           QgsExpressionContext, QgsExpressionContextUtils,
                           QgsMapRendererParallelJob, QgsMapSettings, QgsProject, QgsRectangle,
                           QgsVectorLayer)
except ImportError:
    print("python3-qgis is not installed")
    sys.exit(SKIPPED)

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "cluster"))
from simulated_block import make_block, run  # noqa: E402

WITH_STYLES = {"photos", "patches", "footprints", "residuals x 100"}


def make_finished_block(orient, folder):
    make_block(orient, folder, 3, "--camera-preset", "digital", "--pixel-size-um", 40, "--gsd-m", 0.5,
               "--relief-m", 50)
    run(orient, "block", folder / "block.toml")
    run(orient, "ortho", folder / "block.toml", "--mosaic")
    # The project must not depend on the folder it was made in.
    shutil.move(folder / "out", folder / "moved")
    return folder / "moved"


def complaints_about_layers(project, found):
    layers = {layer.name(): layer for layer in project.mapLayers().values()}
    for name, layer in layers.items():
        if not layer.isValid():
            found.append(f"{name} cannot be opened: {layer.source()}")
        if layer.crs().authid() != "EPSG:32635":
            found.append(f"{name} is in {layer.crs().authid() or 'no CRS'}")
    for name in WITH_STYLES - layers.keys() | {"mosaic", "seamlines"} - layers.keys():
        found.append(f"there is no layer {name}")
    for name in WITH_STYLES & layers.keys():
        if not isinstance(layers[name].renderer(), QgsCategorizedSymbolRenderer):
            found.append(f"{name} is not drawn by categories")
    return layers


def complaints_about_map_tip(layer, found):
    feature = next(layer.getFeatures())
    context = QgsExpressionContext(QgsExpressionContextUtils.globalProjectLayerScopes(layer))
    context.setFeature(feature)
    tip = QgsExpression.replaceExpressionText(layer.mapTipTemplate(), context)
    print(tip)
    for wanted in (feature["name"], feature["status"], "report.html"):
        if wanted not in tip:
            found.append(f"the map tip of {layer.name()} does not say {wanted}: {tip}")
    for link in [part.split('"')[0] for part in tip.split('file://')[1:]]:
        if not pathlib.Path(link).exists():
            found.append(f"the map tip links to {link}, which is not there")


def draw(project, layers, picture):
    settings = QgsMapSettings()
    root = project.layerTreeRoot()
    shown = [layer for layer in root.layerOrder() if root.findLayer(layer).isVisible()]
    settings.setLayers(shown)
    settings.setDestinationCrs(project.crs())
    settings.setOutputSize(QSize(1000, 800))
    extent = QgsRectangle(layers["footprints"].extent())
    extent.scale(1.1)
    settings.setExtent(extent)
    job = QgsMapRendererParallelJob(settings)
    job.start()
    job.waitForFinished()
    image = job.renderedImage()
    image.save(picture)
    colours = {image.pixel(x, y) for x in range(0, 1000, 7) for y in range(0, 800, 7)}
    return [layer.name() for layer in shown], len(colours)


def main(orient, picture=None):
    with tempfile.TemporaryDirectory() as temporary:
        folder = make_finished_block(orient, pathlib.Path(temporary) / "block")
        application = QgsApplication([], False)
        application.initQgis()
        project, found = QgsProject.instance(), []
        if not project.read(str(folder / "block.qgz")):
            sys.exit("QGIS cannot read block.qgz")
        layers = complaints_about_layers(project, found)
        if not layers["photos"].labelsEnabled():
            found.append("photos have no labels")
        complaints_about_map_tip(layers["photos"], found)
        alone = QgsVectorLayer(f"{folder}/block.gpkg|layername=photos", "photos", "ogr")
        if not isinstance(alone.renderer(), QgsCategorizedSymbolRenderer):
            found.append("block.gpkg's own style is not taken")
        shown, colours = draw(project, layers, picture or f"{temporary}/map.png")
        if not {"photos", "mosaic", "footprints"} <= set(shown) or colours < 100:
            found.append(f"the map shows {shown} in {colours} colours")
        project.clear()
        del alone, layers
        application.exitQgis()
    print("\n".join(found) or "QGIS shows the block as it is meant")
    sys.stdout.flush()
    os._exit(1 if found else 0)  # Qt's threads may outlive the interpreter


if __name__ == "__main__":
    main(*sys.argv[1:])
