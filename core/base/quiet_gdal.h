// GDAL prints its errors to stderr unless told otherwise; in Orient every error becomes an
// exception or "no value". While an object of this class lives, its thread's errors are kept for
// the message. Only for .cpp files that use GDAL.
#pragma once

#include <cpl_error.h>
#include <gdal.h>

#include <mutex>
#include <string>

namespace orient {

class QuietGdal {
 public:
  QuietGdal() {
    CPLErrorReset();
    CPLPushErrorHandler(CPLQuietErrorHandler);
  }
  ~QuietGdal() { CPLPopErrorHandler(); }
  QuietGdal(const QuietGdal&) = delete;
  QuietGdal& operator=(const QuietGdal&) = delete;

  // " (what GDAL said)", or nothing.
  std::string Message() const {
    const std::string message = CPLGetLastErrorMsg();
    if (message.empty()) return message;
    return std::string(" (").append(message).append(")");
  }
};

// Registers GDAL's drivers, once a process.
inline void RegisterGdalDrivers() {
  static std::once_flag once;
  std::call_once(once, GDALAllRegister);
}

}  // namespace orient
