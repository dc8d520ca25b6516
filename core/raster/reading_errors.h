// What GDAL says while pixels are read, caught instead of printed, with what counts as an error
// there. Internal to core/imaging.
#pragma once

#include <string>

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

}  // namespace orient
