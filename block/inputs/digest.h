// What tells an input's content from another's, for the Inputs that a result was made from: a
// resumed run takes over only what it would have made itself.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/files/camera_file.h"
#include "core/files/inputs.h"
#include "core/files/orientation_table.h"
#include "interior/interior.h"

namespace orient::block {

// Sixteen hexadecimal digits (FNV-1a, 64 bit): tells inputs apart, and is no protection against
// forgery.
std::string Digest(const std::string& text);

// The same of a text that comes in pieces.
class DigestOfPieces {
 public:
  void Add(std::string_view piece);
  std::string Digits() const;

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325u;
};

// Of several inputs, as one of another result.
std::string DigestOf(const Inputs& inputs);

// Of a file's length and three pieces of it, so that a large scan is not read for it; empty where
// it cannot be read. Whatever GDAL reads, /vsi paths too.
std::string DigestOfFile(const std::string& path);

// Of all of a file that is read as a whole, a table or a result; empty where there is none.
std::string DigestOfContents(const std::string& path);

// Of a raster's files, those that it is put together from too (a VRT's): length, time of change and
// pieces of each, for heights may be corrected in place and in the middle of a file. Empty where it
// cannot be read.
std::string DigestOfRaster(const std::string& path);

// What is known of a photo's pose beforehand, as a text that changes when it does; null: nothing.
std::string TextOf(const OrientationRow* row);

// Of all a camera file says, comments aside, and of the pictures of its marks.
std::string DigestOfCamera(const CameraFile& camera);

// Of those options that a result depends on.
std::string DigestOfOptions(const interior::InteriorOptions& options);

}  // namespace orient::block
