// Points as GeoPackage geometry BLOBs (OGC 12-128r18, clause 2.1.3), and the SQL functions that the
// triggers of a GeoPackage's R-tree call.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

struct sqlite3;

namespace orient::patchdb {

// Header "GP", version 0, little-endian, no envelope, srs_id; then WKB POINT Z (type 1001).
std::vector<unsigned char> EncodePointZ(const Eigen::Vector3d& point_m, int srs_id);

// Either byte order, with or without an envelope. Empty for anything that is not a POINT Z.
std::optional<Eigen::Vector3d> DecodePointZ(const unsigned char* blob, std::size_t size);

// ST_MinX, ST_MaxX, ST_MinY, ST_MaxY and ST_IsEmpty for one connection. Points need no envelope;
// other geometries answer with theirs, NULL where they carry none.
void RegisterSpatialFunctions(sqlite3* connection);

}  // namespace orient::patchdb
