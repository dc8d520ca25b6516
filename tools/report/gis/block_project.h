// block.qgz: what a block's folder holds, as a project of QGIS.
#pragma once

#include <string>

namespace orient {

// Writes directory/block.qgz whole or not at all and returns its path: the layers of block.gpkg as
// their styles draw them, and of directory/ortho the mosaic, its seamlines and the orthophotos,
// where they are there. Paths in it are relative: the folder may be moved. Empty, and nothing
// written, without a block.gpkg, or where a project is there that was saved in QGIS. Throws
// InputError naming the file that cannot be read or written.
std::string WriteBlockProject(const std::string& directory);

}  // namespace orient
