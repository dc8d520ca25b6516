#include "core/raster/picture_text.h"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace orient {

void DrawText(const std::string& text, int col, int row, int height_px,
              const std::array<unsigned char, 3>& colour, int width,
              std::vector<unsigned char>* rgb) {
  if (width <= 0 || rgb->size() % (3 * static_cast<size_t>(width)) != 0)
    throw std::invalid_argument("DrawText: the values do not fill rows of the width");
  if (rgb->empty()) return;
  std::string ascii;
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if ((code & 0xC0) == 0x80) continue;  // a UTF-8 character's further bytes
    ascii += code >= 0x20 && code < 0x7F ? c : '?';
  }
  cv::Mat picture(static_cast<int>(rgb->size() / 3 / static_cast<size_t>(width)), width, CV_8UC3,
                  rgb->data());
  constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
  cv::putText(picture, ascii, cv::Point(col, row), kFont,
              cv::getFontScaleFromHeight(kFont, height_px, 1),
              cv::Scalar(colour[0], colour[1], colour[2]), 1, cv::LINE_AA);
}

}  // namespace orient
