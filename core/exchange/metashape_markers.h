// Agisoft Metashape's markers XML (File > Import > Import Markers): points with their projections.
//
// <markers> of the chunk hold the points, with coordinates in the chunk's reference system where
// they are known; <frames> hold where each photo shows them, in pixels whose upper-left centre is
// (0.5, 0.5). Photos are known by their labels: cameras.xml must be imported first.
#pragma once

#include <string>

#include "core/exchange/exchange_block.h"

namespace orient {

// <directory>/markers.xml: control with its ground position, ties without any, so that Metashape's
// own adjustment computes theirs. Ids and labels of the cameras are those of WriteMetashape.
void WriteMetashapeMarkers(const std::string& directory, const ExchangeBlock& block);

}  // namespace orient
