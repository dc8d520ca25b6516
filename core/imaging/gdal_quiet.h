// GDAL's messages, caught instead of printed. Internal to core/imaging.
#pragma once

#include <string>

namespace orient {

// While one lives, what GDAL says on this thread goes in here and not to stderr, and a JPEG that
// ends too early is an error: GDAL's default is to go on in grey.
class GdalQuiet {
 public:
  GdalQuiet();
  ~GdalQuiet();
  GdalQuiet(const GdalQuiet&) = delete;
  GdalQuiet& operator=(const GdalQuiet&) = delete;

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

// Registers GDAL's drivers, once a process.
void RegisterGdalDrivers();

}  // namespace orient
