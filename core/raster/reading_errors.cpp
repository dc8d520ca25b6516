#include "core/raster/reading_errors.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <gdal_priv.h>

#include <algorithm>

#include "core/base/gdal_faults.h"

namespace orient {
namespace {

constexpr const char* kJpegSetting = "GDAL_ERROR_ON_LIBJPEG_WARNING";

// For JPEG within TIFF, GDAL only warns.
bool TellsOfLostPixels(const std::string& text) {
  return text.find("Premature end of JPEG") != std::string::npos ||
         text.find("Corrupt JPEG data") != std::string::npos;
}

void CPL_STDCALL Collect(CPLErr level, CPLErrorNum number, const char* text) {
  if (level < CE_Warning) return;
  if (level >= CE_Failure) NoteGdalError(number, text);
  static_cast<ReadingErrors*>(CPLGetErrorHandlerUserData())->Add(level >= CE_Failure, text);
}

}  // namespace

ReadingErrors::ReadingErrors() {
  CPLPushErrorHandlerEx(Collect, this);
  const char* old = CPLGetThreadLocalConfigOption(kJpegSetting, nullptr);
  had_jpeg_setting_ = old != nullptr;
  if (had_jpeg_setting_) old_jpeg_setting_ = old;
  CPLSetThreadLocalConfigOption(kJpegSetting, "TRUE");
}

ReadingErrors::~ReadingErrors() {
  CPLSetThreadLocalConfigOption(kJpegSetting,
                                had_jpeg_setting_ ? old_jpeg_setting_.c_str() : nullptr);
  CPLPopErrorHandler();
  CPLErrorReset();
}

void ReadingErrors::Add(bool is_error, const char* text) {
  is_error = is_error || TellsOfLostPixels(text);
  failed_ = failed_ || is_error;
  std::string& kept = is_error ? error_ : warning_;
  if (!kept.empty()) return;
  kept = text;
  std::replace(kept.begin(), kept.end(), '\n', ' ');
}

std::string ReadingErrors::Message() const {
  if (!error_.empty()) return error_;
  return warning_.empty() ? "GDAL gives no reason" : warning_;
}

std::optional<std::string> ReadWindow(GDALRasterBand* band, const PixelWindow& window, void* values,
                                      GDALDataType type) {
  return Watched([&]() -> std::optional<std::string> {
    const ReadingErrors errors;
    const CPLErr result =
        band->RasterIO(GF_Read, window.col, window.row, window.width, window.height, values,
                       window.width, window.height, type, 0, 0, nullptr);
    if (result == CE_None && !errors.Failed()) return std::nullopt;
    // Pixels filled in after an error must not stay in the cache. An overview is its own dataset.
    if (band->GetDataset() != nullptr) band->GetDataset()->FlushCache(false);
    return errors.Message();
  });
}

}  // namespace orient
