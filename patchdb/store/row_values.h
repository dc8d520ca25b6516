// Values of a row as the program's own types; NULL is empty. Private to patchdb.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include <optional>
#include <string>

#include "core/base/error.h"
#include "patchdb/store/patch_blobs.h"

namespace orient::patchdb {

inline Bytes BytesOf(const SQLite::Column& column) {
  const auto* bytes = static_cast<const unsigned char*>(column.getBlob());
  return bytes == nullptr ? Bytes() : Bytes(bytes, bytes + column.getBytes());
}

// Throws InputError where it is a text or a blob, of which SQLite would take the leading digits.
inline double RequiredNumberOf(const SQLite::Column& column) {
  if (!column.isInteger() && !column.isFloat())
    throw InputError(std::string("its ") + column.getName() + " is not a number");
  return column.getDouble();
}

inline std::optional<double> CheckedNumberOf(const SQLite::Column& column) {
  if (column.isNull()) return std::nullopt;
  return RequiredNumberOf(column);
}

// As SQLite takes it, for lists, which show damaged rows too.
inline std::optional<double> NumberOf(const SQLite::Column& column) {
  if (column.isNull()) return std::nullopt;
  return column.getDouble();
}

inline std::optional<std::string> TextOf(const SQLite::Column& column) {
  if (column.isNull()) return std::nullopt;
  return column.getString();
}

// Of substr(png, 17, 4), the header's width; 0 where it is none of a chip.
inline int PngWidth(const SQLite::Column& column) {
  const Bytes bytes = BytesOf(column);
  return bytes.size() == 4 && bytes[0] == 0 && bytes[1] == 0 ? bytes[2] << 8 | bytes[3] : 0;
}

}  // namespace orient::patchdb
