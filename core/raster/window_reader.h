// Windows of bands in any order, also of files that can only be decoded from their first row on.
// Internal to core/raster; not for two threads at a time.
#pragma once

#include <cstddef>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/raster/image.h"

class GDALDataset;
class GDALRasterBand;

namespace orient {

// A JPEG, a PNG, a large compressed strip is decoded as a whole: each window above the one before
// would begin anew at its first row. When that happens first, all of it is decoded once, into a
// file without a name in $TMPDIR or /var/tmp that takes a byte or two a value. Where there is no
// room for it, and for small ones, which GDAL keeps in memory, things stay as they are.
class WindowReader {
 public:
  // Bands of one size, of `dataset` or of an overview of it, which outlive the reader.
  WindowReader(GDALDataset* dataset, std::vector<GDALRasterBand*> bands);

  // As ReadWindow (reading_errors.h) does.
  std::optional<std::string> Read(std::size_t band, const PixelWindow& window, float* values);

 private:
  void Decode();
  bool DecodeRows(int row, int count, std::vector<unsigned char>* rows);
  // False where what was decoded cannot be read any more.
  bool ReadDecoded(std::size_t band, const PixelWindow& window, float* values) const;
  std::size_t Place(std::size_t band, int row, int col) const;  // byte in the file

  std::vector<GDALRasterBand*> bands_;
  std::size_t width_, height_, value_bytes_;
  bool decodes_all_;  // for any window
  int lowest_ = 0;    // row after the lowest window's
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> decoded_{nullptr, &std::fclose};
  int decoded_rows_ = 0;  // up to where the file is damaged
};

}  // namespace orient
