#include "patchdb/store/geopackage_geometry.h"

#include <sqlite3.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>

namespace orient::patchdb {
namespace {

constexpr std::uint32_t kWkbPoint = 1;
constexpr std::uint32_t kWkbPointZ = 1001;
constexpr std::size_t kHeaderSize = 8;  // "GP", version, flags, srs_id
constexpr std::size_t kWkbPrefix = 5;   // byte order, geometry type
constexpr unsigned char kEmptyFlag = 0x10;

// Envelope of the GeoPackage header by its indicator: none, xy, xyz, xym, xyzm.
constexpr std::size_t kEnvelopeSize[] = {0, 32, 48, 48, 64};

template <typename T>
T ReadNumber(const unsigned char* bytes, bool little_endian) {
  unsigned char raw[sizeof(T)];
  std::memcpy(raw, bytes, sizeof(T));
  if (little_endian != (std::endian::native == std::endian::little))
    for (std::size_t i = 0; i < sizeof(T) / 2; ++i) std::swap(raw[i], raw[sizeof(T) - 1 - i]);
  T value;
  std::memcpy(&value, raw, sizeof(T));
  return value;
}

template <typename T>
void AppendLittleEndian(T value, std::vector<unsigned char>& bytes) {
  unsigned char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  const T ordered = ReadNumber<T>(raw, true);
  std::memcpy(raw, &ordered, sizeof(T));
  bytes.insert(bytes.end(), raw, raw + sizeof(T));
}

struct Header {
  bool little_endian = true;
  bool empty = false;
  int envelope = 0;
  std::size_t wkb_offset = 0;
};

std::optional<Header> ReadHeader(const unsigned char* blob, std::size_t size) {
  if (blob == nullptr || size < kHeaderSize || blob[0] != 'G' || blob[1] != 'P')
    return std::nullopt;
  const unsigned char flags = blob[3];
  const int envelope = (flags >> 1) & 7;
  if (envelope > 4) return std::nullopt;
  Header header{(flags & 1) != 0, (flags & kEmptyFlag) != 0, envelope,
                kHeaderSize + kEnvelopeSize[envelope]};
  if (size < header.wkb_offset) return std::nullopt;
  return header;
}

struct Extent {
  bool empty = false;
  double min_x = 0, max_x = 0, min_y = 0, max_y = 0;
};

std::optional<Extent> ReadExtent(const unsigned char* blob, std::size_t size) {
  const auto header = ReadHeader(blob, size);
  if (!header) return std::nullopt;
  if (header->empty) return Extent{true, 0, 0, 0, 0};
  if (header->envelope != 0) {
    const auto at = [&](int i) {
      return ReadNumber<double>(blob + kHeaderSize + 8 * i, header->little_endian);
    };
    return Extent{false, at(0), at(1), at(2), at(3)};
  }
  const unsigned char* wkb = blob + header->wkb_offset;
  if (size - header->wkb_offset < kWkbPrefix + 16) return std::nullopt;
  const bool little = wkb[0] == 1;
  if (ReadNumber<std::uint32_t>(wkb + 1, little) % 1000 != kWkbPoint) return std::nullopt;
  const double x = ReadNumber<double>(wkb + kWkbPrefix, little);
  const double y = ReadNumber<double>(wkb + kWkbPrefix + 8, little);
  return Extent{false, x, x, y, y};
}

std::optional<Extent> ExtentOfArgument(sqlite3_value* value) {
  if (sqlite3_value_type(value) != SQLITE_BLOB) return std::nullopt;
  const auto* blob = static_cast<const unsigned char*>(sqlite3_value_blob(value));
  return ReadExtent(blob, static_cast<std::size_t>(sqlite3_value_bytes(value)));
}

template <double Extent::*kField>
void ExtentFunction(sqlite3_context* context, int, sqlite3_value** arguments) {
  const auto extent = ExtentOfArgument(arguments[0]);
  if (!extent || extent->empty) return sqlite3_result_null(context);
  sqlite3_result_double(context, (*extent).*kField);
}

void IsEmptyFunction(sqlite3_context* context, int, sqlite3_value** arguments) {
  const auto extent = ExtentOfArgument(arguments[0]);
  if (!extent) return sqlite3_result_null(context);
  sqlite3_result_int(context, extent->empty ? 1 : 0);
}

}  // namespace

std::vector<unsigned char> EncodePointZ(const Eigen::Vector3d& point_m, int srs_id) {
  std::vector<unsigned char> blob = {'G', 'P', 0, 1};
  AppendLittleEndian<std::int32_t>(srs_id, blob);
  blob.push_back(1);
  AppendLittleEndian<std::uint32_t>(kWkbPointZ, blob);
  for (int i = 0; i < 3; ++i) AppendLittleEndian<double>(point_m[i], blob);
  return blob;
}

std::optional<Eigen::Vector3d> DecodePointZ(const unsigned char* blob, std::size_t size) {
  const auto header = ReadHeader(blob, size);
  if (!header || header->empty) return std::nullopt;
  if (size - header->wkb_offset < kWkbPrefix + 24) return std::nullopt;
  const unsigned char* wkb = blob + header->wkb_offset;
  const bool little = wkb[0] == 1;
  if (ReadNumber<std::uint32_t>(wkb + 1, little) != kWkbPointZ) return std::nullopt;
  Eigen::Vector3d point;
  for (int i = 0; i < 3; ++i) point[i] = ReadNumber<double>(wkb + kWkbPrefix + 8 * i, little);
  if (!point.allFinite()) return std::nullopt;
  return point;
}

void RegisterSpatialFunctions(sqlite3* connection) {
  using Function = void (*)(sqlite3_context*, int, sqlite3_value**);
  const std::pair<const char*, Function> functions[] = {{"ST_MinX", ExtentFunction<&Extent::min_x>},
                                                        {"ST_MaxX", ExtentFunction<&Extent::max_x>},
                                                        {"ST_MinY", ExtentFunction<&Extent::min_y>},
                                                        {"ST_MaxY", ExtentFunction<&Extent::max_y>},
                                                        {"ST_IsEmpty", IsEmptyFunction}};
  // Innocuous: a trigger may call them although the schema of an opened file is not trusted.
  constexpr int kFlags = SQLITE_UTF8 | SQLITE_DETERMINISTIC | SQLITE_INNOCUOUS;
  for (const auto& [name, function] : functions)
    if (sqlite3_create_function_v2(connection, name, 1, kFlags, nullptr, function, nullptr, nullptr,
                                   nullptr) != SQLITE_OK)
      throw std::runtime_error(std::string("SQLite refuses the function ") + name);
}

}  // namespace orient::patchdb
