// Which heights ground can have.
#pragma once

namespace orient {

// In metres, whatever the vertical datum: the void values of height models lie beyond, and so do
// other numbers that are taken for heights. NaN is none.
constexpr bool CanBeGround(double height_m) { return height_m >= -1000 && height_m <= 10000; }

}  // namespace orient
