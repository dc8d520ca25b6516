// Oriented photos as `orient ortho` takes them: from a folder of results, or a table of poses, and
// their scans.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/raster/band_raster.h"
#include "core/terrain/crs.h"
#include "ortho/orthophoto.h"

namespace orient {

struct OrthoSource {
  std::string poses = {};  // a folder of `orient block` or `orient exterior`, or an OPK CSV
  std::vector<std::string> scans = {};  // a scan whose photo has no result is left out
  std::string camera = {};    // a file; empty: the one that the folder's poses are true with
  std::string interior = {};  // folder of film photos' interior orientations; empty: poses'
  std::string dem = {};
  bool weak = false;  // photos whose status is weak, too
};

struct OrthoPhotos {
  Crs crs;
  std::vector<ortho::OrientedPhoto> photos;
  std::vector<std::string> made_from;  // of each: changes with anything that its orthophoto shows
  std::vector<std::string> left_out;   // "4711: is weak; ..."
};

// Throws InputError, UsageError for what concerns all photos: no table of orientations, no CRS, no
// camera.
OrthoPhotos ReadOrthoPhotos(const OrthoSource& source);

// Throws UsageError where there is a file that no run of 'orient ortho' made: `is_own` tells by
// what its metadata say. One of such a run that was cut off may be replaced.
void RefuseFileOfOthers(const std::string& path,
                        const std::function<bool(const BandRaster&)>& is_own);

}  // namespace orient
