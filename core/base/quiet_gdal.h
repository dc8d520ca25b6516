// GDAL prints its errors to stderr unless told otherwise; in Orient every error becomes an
// exception or "no value". While an object of this class lives, its thread's errors are kept for
// the message. Only for .cpp files that use GDAL.
#pragma once

#include <cpl_error.h>
#include <gdal.h>

#include <mutex>
#include <string>

#include "core/base/gdal_faults.h"

namespace orient {

class QuietGdal {
 public:
  QuietGdal() {
    CPLErrorReset();
    CPLPushErrorHandler([](CPLErr level, CPLErrorNum number, const char* text) {
      if (level >= CE_Failure) NoteGdalError(number, text);
    });
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
  // What the machine refused meanwhile is no fault of a file: throws EnvironmentError.
  void ThrowFaults() const { faults_.ThrowIfAny(); }

 private:
  GdalFaults faults_;
};

// Registers GDAL's drivers and watches its files, once a process.
inline void RegisterGdalDrivers() {
  static std::once_flag once;
  std::call_once(once, [] {
    WatchGdalFiles();
    GDALAllRegister();
  });
}

}  // namespace orient
