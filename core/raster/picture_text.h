// Writing on pictures.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace orient {

// Writes `text` (ASCII; other characters appear as '?') into an RGB picture of `width` pixels a
// row, its lower-left corner at (col, row), capitals `height_px` tall. What does not fit is cut
// off.
void DrawText(const std::string& text, int col, int row, int height_px,
              const std::array<unsigned char, 3>& colour, int width,
              std::vector<unsigned char>* rgb);

}  // namespace orient
