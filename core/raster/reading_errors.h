// What GDAL says while pixels are read, caught instead of printed, with what counts as an error
// there. Internal to core/raster.
#pragma once

#include <gdal_priv.h>

#include <optional>
#include <string>

#include "core/raster/image.h"

namespace orient {

// While one lives, what GDAL says on this thread goes in here and not to stderr, and a JPEG that
// ends too early is an error: GDAL's default is to go on in grey.
class ReadingErrors {
 public:
  ReadingErrors();
  ~ReadingErrors();
  ReadingErrors(const ReadingErrors&) = delete;
  ReadingErrors& operator=(const ReadingErrors&) = delete;

  // An error, or a warning that pixels were made up.
  bool Failed() const { return failed_; }
  // The first error (or else warning) in one line; a general word where GDAL said nothing.
  std::string Message() const;

  void Add(bool is_error, const char* text);  // called by GDAL

 private:
  bool failed_ = false;
  std::string old_jpeg_setting_;
  bool had_jpeg_setting_ = false;
  std::string error_;
  std::string warning_;
};

// The values of a window inside the band, row by row, or why the file does not give them; then
// nothing of it stays in GDAL's cache. Throws EnvironmentError where the machine is at fault.
std::optional<std::string> ReadWindow(GDALRasterBand* band, const PixelWindow& window, void* values,
                                      GDALDataType type);

}  // namespace orient
